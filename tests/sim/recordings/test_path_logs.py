"""Motor logs of a path whose errors are known, and those of the IRB6640."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armside.kinematics import CATALOGUE, LARGE_ROBOT, compile
from armside.sim.recordings import Stream
from armside.sim.recordings.paths import compare_logs, path_scatter, timing_errors, waypoint_path
from armside.sim.recordings.paths.beside_virtual import perfect_scatter
from armside.sim.recordings.paths.waypoint_path import PathLogs, read_path_logs

SETS = Path(os.environ.get("ARMSIDE_MEASUREMENTS") or ".") / "irb6640_logs"
ROBOT, TOOL = compile(LARGE_ROBOT), np.array([0.05, 0.0, 0.3])
START = np.array([0.1, 0.2, 0.3, -0.4, 0.8, 0.2])
SWEEP = np.array([0.5, -0.15, 0.2, 0.6, -0.4, 0.5])
SPEED, PERIOD = 0.25, 0.008
COMMON, OWN = 0.6e-3, 0.5e-3
"""[s] Timing error that the motors share, and that of each."""


def waypoints(n=60):
    phi = START + np.linspace(0.0, 1.0, n)[:, None] * SWEEP
    T = ROBOT.pose(phi)
    return T[:, :3, 3] + T[:, :3, :3] @ TOOL, phi


PATH = waypoint_path(ROBOT, *waypoints())


def log(seed, slow=0.0):
    """Log of a run that follows the path exactly but for `slow` [rad] of motor 2."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, PATH.length / SPEED, PERIOD)
    late = COMMON * rng.normal(size=(len(time), 1)) + OWN * rng.normal(size=(len(time), 6))
    at = np.clip(SPEED * (time[:, None] + late), 0.0, PATH.length)
    phi = np.column_stack([PATH.motor_angles(at[:, j])[:, j] for j in range(6)])
    phi[:, 1] += slow * rng.normal()
    return Stream(time, phi)


def logs(slow=0.0):
    return [log(seed, slow) for seed in range(6)]


def test_tool_and_path_are_those_of_the_waypoints():
    np.testing.assert_allclose(PATH.tool, TOOL, atol=1e-9)
    station, e = PATH.deviation(PATH.motor_angles(np.linspace(0.1, 0.4, 50)))
    np.testing.assert_allclose(station, np.linspace(0.1, 0.4, 50), atol=20e-6)
    assert np.abs(e).max() < 5e-6
    position, phi = waypoints()
    dense = waypoints(2000)[0]
    assert PATH.length == pytest.approx(np.linalg.norm(np.diff(dense, axis=0), axis=1).sum(), 1e-4)
    off = 2e-4 * np.random.default_rng(0).standard_normal(position.shape)
    misfit = waypoint_path(ROBOT, position + off, phi).misfit
    assert misfit == pytest.approx(np.sqrt(3.0) * 2e-4, rel=0.15)


def test_timing_errors_of_each_motor_are_found_whatever_its_rate():
    found = timing_errors(logs())
    # A cubic over 21 samples takes a tenth of the variance of its middle one
    expected = np.sqrt(0.9 * (COMMON**2 + OWN**2))
    np.testing.assert_allclose(found.deviation, expected, rtol=0.1)
    between = found.correlation[np.triu_indices(6, 1)]
    np.testing.assert_allclose(between, COMMON**2 / (COMMON**2 + OWN**2), atol=0.1)
    assert found.period == pytest.approx(PERIOD)


def test_scatter_of_a_perfect_robot_is_explained_by_its_log_and_a_disturbance_is_not():
    rng = np.random.default_rng(0)
    for slow in (0.0, 1e-4):
        runs = logs(slow)
        seen = path_scatter(PATH, [run.values for run in runs]).scatter
        expected = np.mean(perfect_scatter(PATH, SPEED, timing_errors(runs), 6, rng))
        if slow:
            assert seen > 2.0 * expected
        else:
            assert seen == pytest.approx(expected, rel=0.15)


def test_error_is_that_across_the_path_without_its_mean():
    """To first order the Jacobian of a motor, less what lies along the path, less the mean."""
    phi = PATH.motor_angles(PATH.grid)
    off = 1e-4 * (1.0 + np.sin(20.0 * PATH.grid))
    J, T = ROBOT.jacobian(phi), ROBOT.pose(phi)
    moved = (J[:, :3, 1] + np.cross(J[:, 3:, 1], T[:, :3, :3] @ TOOL)) * off[:, None]
    tangent = np.gradient(T[:, :3, 3] + T[:, :3, :3] @ TOOL, PATH.grid, axis=0)
    across = moved - (moved * tangent).sum(axis=1)[:, None] * tangent
    expected = np.sqrt(((across - across.mean(axis=0)) ** 2).sum(axis=1).mean())
    stations = np.linspace(0.0, PATH.length, 4000)
    wave = PATH.motor_angles(stations)
    assert path_scatter(PATH, [wave]).error < 5e-6
    wave[:, 1] += 1e-4 * (1.0 + np.sin(20.0 * stations))
    found = path_scatter(PATH, [wave])
    assert expected > 50e-6
    assert found.error == pytest.approx(expected, rel=0.03)
    normal = np.linalg.svd(waypoints()[0] - waypoints()[0].mean(axis=0))[2][2]
    flat = across - across.mean(axis=0)
    flat = flat - np.outer(flat @ normal, normal)
    assert found.error_in_plane == pytest.approx(np.sqrt((flat**2).sum(axis=1).mean()), rel=0.05)
    assert np.isnan(found.scatter)


def test_the_virtual_robot_runs_the_path_and_repeats_better_than_such_a_log():
    position, phi = (values[:35] for values in waypoints())
    short = PathLogs(position=position, phi=phi, logs={SPEED: logs()})
    (one,) = compare_logs(CATALOGUE["large"], short, runs=2, seed=0).speeds
    assert one.n_runs == 6
    assert one.virtual.scatter < 0.1 * one.virtual_logged.scatter
    assert 0.0 < one.virtual.error < 10e-3


def test_what_cannot_be_right_is_named():
    position, phi = waypoints()
    with pytest.raises(ValueError, match="is it this robot"):
        waypoint_path(ROBOT, position, phi[:, [1, 0, 2, 3, 4, 5]])
    with pytest.raises(ValueError, match="are they in mm"):
        waypoint_path(ROBOT, 1e3 * position, phi)
    one = log(0)
    with pytest.raises(ValueError, match="does not pass the whole path"):
        path_scatter(PATH, [one.values[: len(one.values) // 2]])
    with pytest.raises(ValueError, match="all motors move"):
        timing_errors([replace(one, values=np.tile(one.values[:1], (len(one.time), 1)))])


def written(folder, rows=60):
    """Files of the published form."""
    position, phi = waypoints()
    lines = ["breakpoints,primitives,p_bp,q_bp"]
    for k in range(rows):
        p, q = ([float(x) for x in values[k]] for values in (1e3 * position, phi))
        lines.append(f'{k},movel_fit,"[array({p})]","[array({q})]"')
    (folder / "command.csv").write_text("\n".join(lines))
    one = log(0)
    table = np.column_stack([one.time, np.linspace(-1, 90, len(one.time)), np.degrees(one.values)])
    header = "timestamp, cmd_num, J1, J2, J3, J4, J5, J6"
    np.savetxt(folder / "run_0_v250_z10.csv", table, "%.9g", ", ", header=header, comments="")
    return table, header


def test_files_as_published_are_read_with_their_units(tmp_path):
    table, header = written(tmp_path)
    read = read_path_logs(tmp_path)
    ((speed, (read_log,)),) = read.logs.items()
    assert speed == SPEED
    np.testing.assert_allclose(read.position, waypoints()[0], atol=1e-9)
    np.testing.assert_allclose(read_log.values[-1], log(0).values[-1], atol=1e-7)
    file = tmp_path / "run_0_v250_z10.csv"
    table[200, 0] = table[100, 0]
    np.savetxt(file, table, "%.9g", ", ", header=header, comments="")
    clock = r"column time, row .*the clock (stands still|runs backwards)"
    with pytest.raises(ValueError, match=clock):
        read_path_logs(tmp_path)
    np.savetxt(file, table[:, :5], "%.9g", ", ", header=header, comments="")
    with pytest.raises(ValueError, match="must have 8 columns, got 5"):
        read_path_logs(tmp_path)
    file.unlink()
    with pytest.raises(ValueError, match="has no logs"):
        read_path_logs(tmp_path)
    written(tmp_path, rows=5)
    with pytest.raises(ValueError, match="at least 30 waypoints"):
        read_path_logs(tmp_path)


@pytest.mark.skipif(not SETS.is_dir(), reason="ARMSIDE_MEASUREMENTS names no folder irb6640_logs")
def test_scatter_of_the_irb6640_is_that_of_its_log():
    read = read_path_logs(SETS)
    assert len(read.logs) == 3
    for one in compare_logs(CATALOGUE["large"], read, runs=2, seed=0).speeds:
        np.testing.assert_allclose(one.timing.deviation, 0.8e-3, atol=0.12e-3)
        assert one.real.scatter == pytest.approx(one.perfect.mean(), rel=0.15)
        assert one.virtual.scatter < 5e-6
        assert one.real.error < 0.3e-3
