"""Public results again from the files of a run, by other means: numpy, scipy and shapely."""

import json
import xml.etree.ElementTree as ET
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pyarrow.parquet as pq
import pytest
import shapely
from scipy.linalg import eigh
from scipy.optimize import least_squares
from scipy.signal import butter, freqz, lfilter
from scipy.spatial.transform import Rotation
from tests.sim.controller.robots import CELL, START, guided
from tests.sim.controller.robots import programmed as programmed_arm

from armside.assets import LARGE_ROBOT_XML
from armside.kinematics import (
    CATALOGUE,
    IRB1400,
    IRB1400_LIMITS,
    LARGE_ROBOT,
    compile,
    read_robot,
)
from armside.sim.cell import LARGE_CELL
from armside.sim.controller import Answer, Phase, State
from armside.sim.controller.egm import EgmWire
from armside.sim.controller.rsi import RsiWire
from armside.sim.imu.vibration import lines, power_spectrum
from armside.sim.recordings import read_poses
from armside.sim.robot.kinematics_check import configurations

UR10 = Path(__file__).parents[2] / "docs/examples/ur10_tmac"

RADIUS, BEAM = 5e-3, 2e-4
"""[m], defaults of `armside laser`."""
SEEN = [("tracker", ""), ("true_tool_position", "_true")]
"""Columns of the tool's position, and what ends the names of their measures."""
SEAM = 0.02
"""Of measures from 4 ms samples, about 100 a contour: its begin is known to one of them."""


def read(folder, name="summary.json"):
    return json.loads((folder / name).read_text(encoding="utf-8"))


def recorded(folder, k, signal, begin=-np.inf, end=np.inf):
    """(N,) time and (N, 3) position of run k that a Parquet file has within those times [s]."""
    table = pq.read_table(folder / "signals.parquet", filters=[("k", "=", k)])
    time = table["time"].to_numpy()
    columns = [table[f"{signal}_{axis}"].to_numpy(zero_copy_only=False) for axis in "xyz"]
    position = np.stack(columns, axis=1).astype(float)
    seen = np.isfinite(position).all(axis=1) & (time >= begin) & (time < end)
    return time[seen], position[seen]


def programmed(folder) -> dict[str, Any]:
    return json.loads(pq.read_schema(folder / "signals.parquet").metadata[b"armside.path"])


def centre_and_radius(p):
    """Of the circle with the least squared distances from points (N, 2)."""

    def off(x):
        return np.hypot(*(p - x[:2]).T) - x[2]

    x = least_squares(off, [*p.mean(axis=0), np.ptp(p) / 2], xtol=1e-15, ftol=1e-15).x
    return x[:2], x[2]


def by_angle(p, angle):
    """Columns of (N, c) at those angles of its first two about zero."""
    own = np.arctan2(p[:, 1], p[:, 0])
    order = np.argsort(own)
    radius = np.hypot(p[:, 0], p[:, 1])
    columns = [radius, *p.T[2:]]
    return [np.interp(angle, own[order], c[order], period=2 * np.pi) for c in columns]


@pytest.fixture(scope="module", params=[(k, *seen) for k in (0, 1) for seen in SEEN])
def turn(small_runs, request):
    """Turn of run k about its centre with its height (N, 3) [m], row of the summary and suffix."""
    folder, (k, signal, suffix) = small_runs / "laser", request.param
    _, p = recorded(folder, k, signal, *programmed(folder)["contour_time"])
    centre, _ = centre_and_radius(p[:, :2])
    p[:, :2] -= centre
    summary = read(folder)
    return p, summary, summary["iterations"][k], suffix


def test_arm_measures_are_those_of_a_fitted_circle_in_the_file(turn):
    p, _, row, suffix = turn
    deviation = np.hypot(p[:, 0], p[:, 1]) - RADIUS
    assert row[f"arm_rms{suffix}"] == pytest.approx(np.sqrt(np.mean(deviation**2)), rel=1e-6)
    assert row[f"arm_maxdev{suffix}"] == pytest.approx(np.abs(deviation).max(), rel=1e-6)


def test_path_accuracy_is_the_largest_distance_from_the_circle_at_its_angles(turn):
    """Places are found by the angle, not by crossings of normals: alike to second order."""
    p, summary, row, suffix = turn
    angle = 2 * np.pi * np.arange(200) / 200
    radius, height = by_angle(p, angle)
    off = (radius - RADIUS)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    flat = np.linalg.norm(off - off.mean(axis=0), axis=1)
    iso, k = summary["iso"], row["k"]
    whole = np.hypot(flat, height - height.mean()).max()
    assert iso[f"path_accuracy_in_plane{suffix}"][k] == pytest.approx(flat.max(), rel=0.02)
    assert iso[f"path_accuracy{suffix}"][k] == pytest.approx(whole, rel=0.02)


def test_the_kerf_is_the_buffer_of_shapely(turn):
    p, summary, row, suffix = turn
    ring = shapely.LinearRing(p[:, :2]).buffer(BEAM / 2, quad_segs=64)
    hole, piece = (np.array(r.coords)[:-1] for r in (ring.exterior, *ring.interiors))
    angle = 2 * np.pi * np.arange(2000) / 2000
    (outer,), (inner,) = by_angle(hole, angle), by_angle(piece, angle)
    edge = outer[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    centre, _ = centre_and_radius(edge)
    kerf, k = summary["kerf"], row["k"]
    assert kerf["beam"] == BEAM
    round_ = np.ptp(np.hypot(*(edge - centre).T))
    assert kerf[f"hole_roundness{suffix}"][k] == pytest.approx(round_, rel=0.01)
    if suffix:
        assert kerf["widest_true"][k] == pytest.approx((outer - inner).max(), rel=0.01)


def test_normalised_measures_are_fractions_of_the_first_and_its_worst_motor(small_runs):
    first, last = read(small_runs / "laser")["iterations"]
    for name in ("motor_inf", "motor_two"):
        expected = np.array(last[name]) / max(first[name])
        np.testing.assert_allclose(last[f"{name}_normalised"], expected, rtol=1e-12)
    for name in ("arm_rms", "arm_maxdev"):
        assert last[f"{name}_normalised"] == pytest.approx(last[name] / first[name], rel=1e-12)


def test_the_reached_speed_is_the_length_of_the_turn_over_its_time(small_runs):
    begin, end = programmed(small_runs / "laser")["contour_time"]
    reached = read(small_runs / "laser")["reached_speed"]
    assert reached == pytest.approx(2 * np.pi * RADIUS / (end - begin), rel=1e-9)
    time, p = recorded(small_runs / "laser", 1, "true_tool_position", begin, end)
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(time)
    assert speed.mean() == pytest.approx(reached, rel=0.05)  # the tool is off by some per cent


# A part: a round hole of 8 mm, 2 mm beside the middle of an outline of 16 x 12 mm.


@pytest.fixture(scope="module", params=SEEN)
def hole(small_runs, request):
    """Turn of the hole (N, 3) [m] from the place of the drawing, its entry and suffix."""
    folder, (signal, suffix) = small_runs / "cut", request.param
    entry, path = read(folder)["contours"][0], programmed(folder)
    on_contour = entry["length"] / entry["reached_speed"]
    begin = entry["start"] + (entry["seconds"] - on_contour) / 2  # leads are alike
    _, p = recorded(folder, 0, signal, begin, begin + on_contour)
    _, rest = recorded(folder, 0, signal, end=0.2)
    place = np.add(path["plane"]["origin"], [*np.subtract([6e-3, 6e-3], path["middle"]), 0.0])
    lower_left = np.add(path["plane"]["origin"], [*np.multiply(path["middle"], -1.0), 0.0])
    return p - place - (rest.mean(axis=0) - lower_left), entry, suffix


def test_measures_of_a_contour_are_those_of_a_fitted_circle_in_the_file(hole):
    p, entry, suffix = hole
    assert entry["length"] == pytest.approx(2 * np.pi * (4e-3 - BEAM / 2))
    centre, _ = centre_and_radius(p[:, :2])
    deviation = np.hypot(*(p[:, :2] - centre).T) - (4e-3 - BEAM / 2)
    (row,) = entry["iterations"]
    assert row[f"arm_rms{suffix}"] == pytest.approx(np.sqrt(np.mean(deviation**2)), rel=SEAM)
    assert row[f"arm_maxdev{suffix}"] == pytest.approx(np.abs(deviation).max(), rel=SEAM)
    # the middle of the samples, which are nearly even around the turn
    assert row[f"arm_position{suffix}"] == pytest.approx(np.linalg.norm(centre), abs=5e-6)
    height = p[:, 2] - p[:, 2].mean()
    accuracy = np.hypot(deviation, height).max()
    assert row[f"arm_path_accuracy{suffix}"] == pytest.approx(accuracy, rel=SEAM)


def test_a_part_takes_the_sum_of_its_legs_and_its_measures_are_the_worst(small_runs):
    """Each leg begins where the one before ends; a beam pierces 0.3 s, after the rapid move."""
    summary = read(small_runs / "cut")
    (whole,), each = summary["iterations"], [c["iterations"][0] for c in summary["contours"]]
    for name in ("maxdev", "position", "path_accuracy", "roundness", "corner"):
        for suffix in ("", "_true"):
            values = [row[f"arm_{name}{suffix}"] for row in each]
            assert whole[f"arm_{name}{suffix}"] == max(v for v in values if v is not None)
    first, last = summary["contours"]
    assert last["start"] + last["seconds"] == pytest.approx(0.28 + summary["seconds"], abs=1e-6)
    assert last["start"] - first["start"] - first["seconds"] > 0.3
    for contour in (first, last):
        assert contour["asked_speed"] == 0.06
        assert contour["reached_speed"] == pytest.approx(0.06, rel=1e-3)
        assert contour["seconds"] > contour["length"] / contour["reached_speed"]


def test_a_program_has_its_blocks_at_the_speed_of_the_cut(small_runs):
    """Targets of a hole are that far apart on its circle, and so many pass in a second."""
    program = read(small_runs / "cut")["program"]
    text = (small_runs / "cut" / program["file"]).read_text()
    moves = [line for line in text.splitlines() if "MoveL" in line and "vCut" in line]
    points = [list(map(float, m.split("[[")[1].split("]")[0].split(","))) for m in moves]
    steps = np.array([1e-3 * np.linalg.norm(np.subtract(b, a)) for a, b in pairwise(points)])
    assert np.median(steps) == pytest.approx(program["spacing"], rel=0.01)
    most = 0.06 / steps.min()  # rounded to a micrometre of 0.3 mm
    assert program["blocks_per_second"] == pytest.approx(most, rel=0.02)
    assert program["targets"] == text.count("MoveL")


# Laws on y = lag (r + u), and what a design is for


LAG = partial(lfilter, [0, 0.1], [1, -0.9])


def test_errors_of_learning_are_those_of_a_filtered_reference(small_runs):
    (law, own), sizes = read(small_runs / "learn")["laws"], []
    r = np.loadtxt(small_runs / "learn/reference.csv", delimiter=",", skiprows=1)[:, 1]
    u = np.zeros_like(r)
    for _ in range(2):
        e = r - LAG(r + u)
        sizes.append((np.linalg.norm(e), np.abs(e).max()))
        u = u + 0.5 * e
    (file,) = (small_runs / "learn").glob("correction-2-*.csv")
    written = np.loadtxt(file, delimiter=",", skiprows=1)
    np.testing.assert_allclose(written[:, 1], 0.5 * (r - LAG(r)), atol=1e-12)  # that of k = 1
    np.testing.assert_allclose(np.diff(written[:, 0]), 0.01, rtol=1e-9)
    for name, expected in zip(("error_two", "error_inf"), np.transpose(sizes), strict=True):
        np.testing.assert_allclose(own[name], expected, rtol=1e-9)
    np.testing.assert_allclose(own["predicted"]["error_two"], own["error_two"], rtol=1e-9)
    assert law["predicted"]["criterion"] == pytest.approx(criterion(0.5, 1), rel=1e-6)


def criterion(gamma, delta, cutoff=10.0):
    """Supremum of Q |1 - gamma z^delta T| for the lag at 100 Hz."""
    omega = np.linspace(0.0, np.pi, 100_001)[1:-1]
    z = np.exp(1j * omega)
    Q = np.abs(freqz(*butter(2, cutoff, fs=100.0), worN=omega)[1]) ** 2
    return (Q * np.abs(1.0 - gamma * z**delta * 0.1 / (z - 0.9))).max()


def test_a_design_contracts_as_it_says_and_not_beyond_its_limits(small_runs):
    found = read(small_runs / "design")["design"]
    gamma, delta, cutoff = (found[name] for name in ("gamma", "delta", "cutoff"))
    assert found["contraction"] == pytest.approx(criterion(gamma, delta), rel=1e-6)
    assert found["iterations_to_5_percent"] == np.ceil(
        np.log(0.05) / np.log(criterion(gamma, delta))
    )
    for factor, converges in ((0.999, True), (1.001, False)):
        assert (criterion(factor * found["largest_gamma"], delta, cutoff) < 1.0) == converges
        assert (criterion(gamma, delta, factor * found["largest_cutoff"]) < 1.0) == converges


# Programs, exported corrections, columns


def test_rows_of_a_program_are_those_of_its_text(small_runs):
    text = (small_runs / "cut/armside.mod").read_text()
    lines = [line for line in text.splitlines() if line.strip().startswith("Move")]
    points = np.array([[*map(float, m.split("[[")[1].split("]")[0].split(","))] for m in lines])
    steps = 1e-3 * np.linalg.norm(np.diff(points, axis=0), axis=1)
    (row,) = read(small_runs / "read")["rows"]
    expected = steps.min(), np.median(steps), steps.max()
    np.testing.assert_allclose(row["spacing"], expected, rtol=1e-9)
    speeds = np.array([0.06 if "vCut" in line else 0.2 for line in lines[1:]])
    assert row["blocks_per_second"] == pytest.approx((speeds / steps).max(), rel=1e-9)


def test_an_exported_correction_has_the_largest_rate_and_number_of_the_file(small_runs):
    about = read(small_runs / "correction")
    text = (small_runs / "joint-correction.csv").read_text().splitlines()
    head, *rows = [line for line in text if not line.startswith("#")]
    assert head.split(",")[:2] == ['"time"', '"correction_1"']
    rows = np.array([[*map(float, row.split(","))] for row in rows])
    assert about["samples"] == len(rows)
    assert about["largest"] == np.abs(rows[:, 1:]).max()
    assert 1e-5 < about["largest"] < 0.01  # rad: a millimetre two metres away, as the file says
    for name in ("path", "tool"):
        time = pq.read_table(small_runs / f"{name}.parquet")["time"].to_numpy()
        np.testing.assert_allclose(np.diff(time), 1.0 / about["rate"], rtol=1e-9)
    np.testing.assert_allclose(np.diff(rows[:, 0]), 0.004, rtol=1e-9)
    tool = pq.read_table(small_runs / "tool.parquet")
    q = np.array([tool[f"tool_q{axis}"].to_numpy() for axis in "wxyz"])
    # a cut keeps its orientation: that of the tool at p1, w first
    off = np.abs(q.T @ programmed(small_runs / "laser")["quaternion"])
    np.testing.assert_allclose(off, 1.0, atol=1e-6)


def test_columns_of_a_run_are_consistent_with_its_kinematics(small_runs):
    """By the D-H table alone: the tool bends from it by less than 5 mm and 5 mrad, the tracker sees
    it within 1 mm, and the IMU turns as the tool's orientation does."""
    table = pq.read_table(small_runs / "laser/signals.parquet", filters=[("k", "=", 0)])

    def columns(name, suffixes="xyz"):
        of = [table[f"{name}_{s}"].to_numpy(zero_copy_only=False) for s in suffixes]
        return np.stack(of, axis=1).astype(float)

    axes = range(1, 7)
    logged = np.isfinite(columns("reference", axes)).all(axis=1)
    for name, within in (("reference", 5e-3), ("motor_angle", 5e-3)):
        T = compile(LARGE_ROBOT).pose(columns(name, axes)[logged])
        off = T[:, :3, 3] - columns("true_tool_position")[logged]
        assert np.linalg.norm(off, axis=1).max() < within
        turned = Rotation.from_matrix(T[:, :3, :3]).inv()
        q = columns("true_tool_quaternion", "wxyz")[logged]
        assert (turned * Rotation.from_quat(q, scalar_first=True)).magnitude().max() < within
    assert np.abs(columns("tracker") - columns("true_tool_position")).max() < 1e-3
    assert np.ptp(columns("true_tool_position")[:, 0]) == pytest.approx(2 * RADIUS, rel=0.1)
    time = table["time"].to_numpy()
    tool = Rotation.from_quat(columns("true_tool_quaternion", "wxyz"), scalar_first=True)
    rate = np.linalg.norm((tool[:-2].inv() * tool[2:]).as_rotvec(), axis=1) / (time[2:] - time[:-2])
    measured = np.linalg.norm(columns("true_imu_angular_velocity")[1:-1], axis=1)
    assert np.sqrt(np.mean((rate - measured) ** 2)) < 0.1 * np.sqrt(np.mean(rate**2))


def test_a_run_beside_a_carried_correction_is_that_of_a_fresh_command(small_runs):
    again, fresh = (read(small_runs / name) for name in ("again", "fresh"))
    (expected,), uncorrected = fresh["iterations"], again["started_from"]["uncorrected"]
    assert uncorrected == {name: expected[name] for name in uncorrected}
    assert again["iterations"][0]["motor_inf"] != expected["motor_inf"]


# An IMU on a moving robot


def columns(file, name, suffixes="xyz"):
    """(N, n) without the rows that lack it."""
    table = pq.read_table(file)
    of = [table[f"{name}_{s}"].to_numpy(zero_copy_only=False).astype(float) for s in suffixes]
    values = np.stack(of, axis=1)
    return values[np.isfinite(values).all(axis=1)]


@pytest.fixture(scope="module")
def moved(small_runs):
    """Entry of the summary, files of signals and of the IMU, and the times of the log."""
    (entry,), folder = read(small_runs / "imu")["experiments"], small_runs / "imu"
    time = pq.read_table(folder / "signals.parquet", filters=[("reference_1", "<", 9.0)])["time"]
    return entry, folder / "signals.parquet", folder / "imu.parquet", time.to_numpy()


def test_measures_of_an_imu_run_are_those_of_its_files(moved):
    entry, signals, imu, time = moved
    at = pq.read_table(imu)["time"].to_numpy()
    late, after = at >= entry["since"], time >= entry["since"]
    assert entry["duration"] == time[-1]
    rate = columns(imu, "angular_velocity_measured") - columns(imu, "angular_velocity_predicted")
    expected = np.sqrt(np.mean(rate[late] ** 2, axis=0))
    np.testing.assert_allclose(entry["angular_velocity_rms"], expected, rtol=1e-9)
    expected = np.abs(rate[late]).max(axis=0)
    np.testing.assert_allclose(entry["angular_velocity_max"], expected, rtol=1e-9)
    peak = np.abs(columns(imu, "acceleration_measured")[late]).max(axis=0)
    np.testing.assert_allclose(entry["acceleration_peak"], peak, rtol=1e-9)
    where = columns(imu, "acceleration_error_rms")[late].argmax(axis=0)
    np.testing.assert_allclose(entry["acceleration_window_time"], at[late][where], rtol=1e-9)
    phi = columns(signals, "motor_angle", range(1, 7))
    table = pq.read_table(signals, filters=[("reference_1", "<", 9.0)])
    tool = np.stack([table[f"true_tool_position_{a}"].to_numpy() for a in "xyz"], axis=1)
    off = np.linalg.norm(compile(IRB1400).pose(phi)[:, :3, 3] - tool, axis=1)
    assert entry["tool_distance"] == pytest.approx(off[after].max(), rel=1e-6)


def test_moves_of_an_imu_run_are_those_of_its_reference(moved):
    """The tool rests before and after, and has its highest speed between: by differences of the
    log, which take 0.2 % off a short peak."""
    entry, signals, _, time = moved
    phi = columns(signals, "reference", range(1, 7))
    rates = np.abs(np.gradient(phi, 0.004, axis=0)) / IRB1400_LIMITS.speed
    p = compile(IRB1400).pose(phi)[:, :3, 3]
    speed = np.linalg.norm(np.gradient(p, 0.004, axis=0), axis=1)
    for move in entry["moves"]:
        during = (time >= move["start"]) & (time <= move["end"])
        of_joints = move["programmed"]["path"] is None
        highest = (rates.max(axis=1) if of_joints else speed)[during].max()
        assert move["reached"] == pytest.approx(highest, rel=5e-3)
    first, last = entry["moves"][0]["start"], entry["moves"][-1]["end"]
    moving = time[speed > 1e-9]
    assert moving[0] == pytest.approx(first, abs=0.008)
    assert moving[-1] == pytest.approx(last, abs=0.008)


def test_columns_of_an_imu_have_the_rate_of_the_clock_and_gravity(moved):
    """At rest before the first move; what is predicted is the motion by the motor angles."""
    entry, signals, imu, _ = moved
    clock = pq.read_table(imu)["imu_time"].to_numpy()
    np.testing.assert_allclose(np.diff(clock), 0.01, rtol=1e-6)
    still = clock < entry["moves"][0]["start"] - 0.1
    force = columns(imu, "imu_acceleration")[still].mean(axis=0)
    assert np.linalg.norm(force) == pytest.approx(9.82, abs=0.2)
    turning = columns(imu, "imu_angular_velocity")
    T = compile(IRB1400).pose(columns(signals, "motor_angle", range(1, 7)))
    turns = Rotation.from_matrix(T[:, :3, :3])
    by_tool = np.linalg.norm((turns[:-1].inv() * turns[1:]).as_rotvec(), axis=1) / 0.004
    for sensed in (turning, columns(imu, "angular_velocity_predicted")):
        rms = np.sqrt(np.mean(np.sum(sensed**2, axis=1)))
        assert rms == pytest.approx(np.sqrt(np.mean(by_tool**2)), rel=0.1)
    predicted, seen = (columns(imu, f"acceleration_{side}") for side in ("predicted", "measured"))
    for axis in range(3):
        slope = predicted[:, axis] @ seen[:, axis] / (seen[:, axis] @ seen[:, axis])
        assert slope == pytest.approx(1.0, abs=0.1)


# Identified plants, calibrated arms, a robot's numbers


def test_a_measured_plant_is_the_one_that_was_excited(small_runs):
    """0.1 q^-1 / (1 - 0.9 q^-1) at 100 Hz, whose output lags."""
    found = read(small_runs / "plant")
    assert found["sample_time"] == 0.01
    values = {c["name"]: c["value"] for c in found["coefficients"]}
    assert values == pytest.approx({"b1": 0.1, "f1": -0.9}, rel=1e-6)
    response = found["frequency_response"]
    z = np.exp(2j * np.pi * 0.01 * np.array(response["frequency"]))
    expected = 0.1 / (z - 0.9)
    np.testing.assert_allclose(response["magnitude"][0], np.abs(expected), rtol=1e-4)
    np.testing.assert_allclose(response["phase"][0], np.angle(expected), atol=1e-4)
    assert (np.array(response["phase"][0]) < 0.0).all()


@pytest.mark.parametrize("name", ["nominal", "geometry"])
def test_held_out_errors_are_those_of_the_written_robots(small_runs, name):
    """Base and target are fitted to the first half by least squares; ours bounds outliers."""
    summary = read(small_runs / "calibrated")
    n = summary["poses"]["fitted"]
    data = read_poses(UR10).measurements
    robot = CATALOGUE["ur10"].robot
    if name == "geometry":
        robot, _ = read_robot(small_runs / "calibrated/calibrated.toml")
    T, points = compile(robot).pose(data.phi), data.points[:, 0]

    def off(x, rows):
        at = T[rows, :3, 3] + T[rows, :3, :3] @ x[6:]
        return points[rows] - Rotation.from_rotvec(x[3:6]).apply(at) - x[:3]

    starts = [np.r_[np.zeros(5), angle, np.zeros(3)] for angle in (0.0, 2.0, -2.0)]
    fits = [least_squares(lambda x: off(x, slice(n)).ravel(), start) for start in starts]
    best = min(fits, key=lambda fit: fit.cost).x
    length = np.linalg.norm(off(best, slice(n, None)), axis=1)
    expected = {"mean": length.mean(), "p95": np.quantile(length, 0.95), "max": length.max()}
    assert summary["held_out"][name] == pytest.approx(expected, rel=0.1)


@pytest.fixture(scope="module")
def axes(small_runs):
    """Columns of `robot check` of the large robot, and its parsed file."""
    found = read(small_runs / "check")
    names = found["axes"][0].keys() - {"joint"}
    columns = {name: np.array([row[name] for row in found["axes"]]) for name in names}
    return found, columns, ET.parse(LARGE_ROBOT_XML).getroot()


def test_limits_and_drives_of_a_check_are_those_of_the_file(axes):
    _, columns, xml = axes
    motors = [xml.find(f".//joint[@name='motor_{i}']") for i in range(1, 7)]
    drives = [xml.find(f".//dcmotor[@name='axis_{i}']") for i in range(1, 7)]
    stops = np.array([[*map(float, m.get("range").split())] for m in motors])
    gear = np.array([float(d.get("gear")) for d in drives])
    peak = np.array([float(d.get("saturation").split()[0]) for d in drives])
    assert columns["gear"] == pytest.approx(gear)
    assert columns["torque_limit"] == pytest.approx(gear * peak)
    assert columns["rotor_inertia"] == pytest.approx([float(m.get("armature")) for m in motors])
    degrees = np.deg2rad(
        [(-180, 180), (-65, 80), (-180, 60), (-300, 300), (-120, 120), (-300, 300)]
    )
    assert columns["lower"] == pytest.approx(degrees[:, 0])
    assert columns["upper"] == pytest.approx(degrees[:, 1])
    inside = np.minimum(degrees[:, 0] - stops[:, 0], stops[:, 1] - degrees[:, 1])
    assert columns["margin"] == pytest.approx(inside, abs=1e-9)


def held_by(mj, phi):
    """(6,) [N m], arm side: slopes of the potential energy at motor angles, springs at rest."""
    mj.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, slopes = mujoco.MjData(mj), []
    motors = [mj.joint(f"motor_{i}").qposadr[0] for i in range(1, 7)]
    for motor in motors:
        ends = []
        for step in (1e-4, -1e-4):
            data.qpos[motors] = phi
            data.qpos[motor] += step
            mujoco.mj_forward(mj, data)
            ends.append(data.energy[0])
        slopes.append((ends[0] - ends[1]) / 2e-4)
    return np.array(slopes)


def test_torques_in_a_file_are_those_of_the_shafts_that_hold_the_arm(small_runs):
    """At rest before the cut. Static friction of the drives and their noise hold 0.2 N m or so."""
    names = {"phi": "reference", "log": "motor_torque", "true": "true_motor_torque"}
    table = pq.read_table(small_runs / "laser/signals.parquet", filters=[("k", "=", 0)])
    phi, log, true = (
        np.array([table[f"{name}_{i}"][0].as_py() for i in range(1, 7)]) for name in names.values()
    )
    mj = mujoco.MjModel.from_xml_path(str(LARGE_ROBOT_XML))
    shaft = held_by(mj, phi) / [220, 242.73, 242.73, 145, 180, 100]
    assert np.abs(shaft).max() > 1.0
    for torque in (log, true):
        np.testing.assert_allclose(torque, shaft, rtol=0.0, atol=0.3)


def test_a_check_has_the_masses_modes_and_torques_of_another_calculation(axes):
    """Masses of the file; K v = w^2 M v by scipy; slopes of the energy in all postures."""
    found, columns, xml = axes
    assert found["mass"] == sum(float(e.get("mass")) for e in xml.iter("inertial"))
    mj = mujoco.MjModel.from_xml_path(str(LARGE_ROBOT_XML))
    data, M = mujoco.MjData(mj), np.empty((mj.nv, mj.nv))
    mujoco.mj_forward(mj, data)
    mujoco.mj_fullM(mj, data, M)
    motors = [mj.joint(f"motor_{i}").dofadr[0] for i in range(1, 7)]
    held = np.setdiff1d(np.arange(mj.nv), motors)
    K = np.diag(mj.jnt_stiffness[mj.dof_jntid[held]])
    omega = np.sqrt(eigh(K, M[np.ix_(held, held)], eigvals_only=True))
    np.testing.assert_allclose(found["locked_modes"], omega / (2 * np.pi), rtol=1e-6)
    postures = configurations(LARGE_CELL.limits)
    assert found["configurations"] == len(postures)
    load = np.abs([held_by(mj, phi) for phi in postures]).max(axis=0) / columns["torque_limit"]
    np.testing.assert_allclose(columns["holding"], load, rtol=1e-4, atol=1e-6)
    highest = []
    springs = np.diag(mj.jnt_stiffness[mj.dof_jntid])
    for phi in postures:
        data.qpos[:] = 0.0
        data.qpos[motors] = phi
        mujoco.mj_forward(mj, data)
        mujoco.mj_fullM(mj, data, M)
        highest.append(np.sqrt(eigh(springs, M, eigvals_only=True)[-1]) / (2 * np.pi))
    assert found["highest_mode"] == pytest.approx(max(highest), rel=1e-6)
    tools = compile(LARGE_ROBOT).pose(postures)[:, :3, 3]
    assert found["reach"] == pytest.approx(np.linalg.norm(tools, axis=1).max(), abs=1e-5)


def test_dexterity_is_the_ratio_of_singular_values_of_a_difference_quotient(small_runs, axes):
    """At p1, in the middle of the turn that is cut around it; the tool moves there by 5 mm."""
    table = pq.read_table(small_runs / "laser/signals.parquet", filters=[("k", "=", 0)])
    names = [f"reference_{i}" for i in range(1, 7)]
    phi = [table[name].to_numpy(zero_copy_only=False).astype(float) for name in names]
    middle = 0.5 * (np.nanmin(phi, axis=1) + np.nanmax(phi, axis=1))
    pose = compile(LARGE_ROBOT).pose
    J, step = np.empty((6, 6)), 1e-6
    for i, e in enumerate(np.eye(6)):
        ahead, behind = pose(middle + step * e), pose(middle - step * e)
        turned = Rotation.from_matrix(ahead[:3, :3] @ behind[:3, :3].T).as_rotvec()
        J[:, i] = np.r_[ahead[:3, 3] - behind[:3, 3], turned] / (2 * step)
    S = np.linalg.svd(J, compute_uv=False)
    found = {one["pose"]: one["dexterity"] for one in axes[0]["poses"]}
    assert found["p1"] == pytest.approx(S[-1] / S[0], rel=0.05)


def test_the_spectrum_of_a_sine_is_at_its_frequency():
    """A second line of half the amplitude has a quarter of the power."""
    time = np.arange(0.0, 60.0, 0.01)
    signal = np.sin(2 * np.pi * 27.0 * time) + 0.5 * np.sin(2 * np.pi * 40.0 * time)
    frequency, density = power_spectrum(signal[:, None], 100.0)
    first, second, *_ = lines(frequency, density[:, 0])
    assert first == pytest.approx((27.0, 1.0), abs=0.05)
    assert second == pytest.approx((40.0, 0.25), abs=0.05)


def test_orientations_of_messages_are_those_of_scipy():
    """Of a robot that leans about all axes: mm and degrees, z y x of KUKA, w first of ABB."""
    turn = Rotation.from_euler("ZYX", [30.0, -40.0, 110.0], degrees=True)
    state = State(
        number=2,
        time=8,
        phase=Phase.GUIDED,
        joints=np.arange(7) + 0.5,
        planned=np.arange(7) + 1.0,
        position=np.array([1200.0, -30.0, 900.0]),
        quaternion=turn.as_quat(scalar_first=True),
        missed=0,
        resting=False,
        programmed=(np.array([1200.0, -30.0, 900.0]), turn.as_quat(scalar_first=True)),
    )
    root = ET.fromstring(RsiWire().encode_state(state))
    places = [{k: float(v) for k, v in root.find(tag).attrib.items()} for tag in ("RIst", "RSol")]
    expected = dict(zip("XYZABC", [1200.0, -30.0, 900.0, 30.0, -40.0, 110.0], strict=True))
    assert places == [pytest.approx(expected)] * 2
    egm = EgmWire()
    feedback = egm._robot.FromString(egm.encode_state(state)).feedBack
    assert (list(feedback.joints.joints), list(feedback.externalJoints.joints)) == (
        [0.5, 1.5, 2.5, 3.5, 4.5, 5.5],
        [6.5],
    )
    orient = feedback.cartesian.orient
    q = Rotation.from_quat([orient.u0, orient.u1, orient.u2, orient.u3], scalar_first=True)
    assert (q * turn.inv()).magnitude() < 1e-9


def test_a_message_of_rsi_has_the_angles_of_the_robot_in_degrees():
    controller = guided()
    root = ET.fromstring(RsiWire().encode_state(controller.state()))
    for tag in ("AIPos", "ASPos"):
        angles = [float(root.find(tag).get(f"A{i}")) for i in (1, 2)]
        np.testing.assert_allclose(np.deg2rad(angles), START, atol=1e-4)  # a step of the encoder


def test_places_in_a_message_of_rsi_are_those_of_its_axes():
    """Of a planar arm on the move: RIst at the measured angles, RSol at the programmed ones."""
    controller, links = programmed_arm(), CELL.robot.links
    for _ in range(20):
        controller.cycle(Answer(values=np.zeros(2), additive=True))
    root = ET.fromstring(RsiWire().encode_state(controller.state()))
    places = []
    for place, axes in (("RIst", "AIPos"), ("RSol", "ASPos")):
        phi = np.deg2rad([float(root.find(axes).get(f"A{i}")) for i in (1, 2)])
        angles = np.cumsum(phi + [link.theta for link in links])
        reach = 1e3 * np.array([link.a for link in links])
        found = [float(root.find(place).get(axis)) for axis in "XY"]
        np.testing.assert_allclose(found, [reach @ np.cos(angles), reach @ np.sin(angles)])
        places.append(found)
    assert np.linalg.norm(np.subtract(*places)) > 0.01
