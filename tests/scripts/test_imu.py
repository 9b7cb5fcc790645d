"""`armside imu`: chapter 5 of the thesis on the virtual IRB1400, and what its errors consist of."""

import copy
import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from mujoco.rollout import Rollout
from scipy.signal import welch

from armside import assets
from armside.scripts.benchmarks import imu as bench_imu
from armside.scripts.benchmarks.timing import interleaved
from armside.scripts.cli import main
from armside.scripts.commands.imu import (
    ImuExperimentCfg,
    causes,
    prepare,
    processing,
    run_one,
    run_rest,
)
from armside.scripts.verifications import irb1400 as verify_irb1400
from armside.scripts.verifications.imu_large import imu_large
from armside.sim.cell import CELLS
from armside.sim.imu.compare import find_offset
from armside.sim.imu.experiment import evaluate, idle_peaks, under_way
from armside.sim.imu.vibration import power_spectrum
from armside.sim.instruments.imu import ImuCfg, draw
from armside.sim.records.signals import read_signals
from armside.sim.robot.flexibility import variant
from armside.sim.robot.model import load_model
from armside.sim.robot.recording import Recording, Truth
from armside.sim.robot.virtual_robot import VirtualRobot

FIGURES = {
    "motor-angles.png",
    "path.png",
    "position.png",
    "angular-velocity.png",
    "acceleration.png",
    "acceleration-error.png",
}
KI = 5  # of a dcmotor's gain parameters
BIAS = 0.5e-3  # [s], of the clocks: what difference quotients and filters do to the prediction


@pytest.fixture(scope="module")
def done():
    cfg = ImuExperimentCfg()
    return run_one(cfg, prepare(cfg)[0], seed=0)


@pytest.fixture(scope="module")
def found():
    return dict(causes(ImuExperimentCfg(), seed=0))


def rms(error):
    return np.sqrt(np.mean(error**2, axis=0))


# Kinematics against the IMU: thesis 5.4.2


def test_angular_velocity_is_predicted_as_well_as_in_the_thesis(done):
    assert done.measures.angular_velocity_rms.max() <= 0.025
    assert done.measures.angular_velocity_max.max() <= 0.15


def test_acceleration_is_predicted_within_the_figure_of_the_thesis(done):
    """Fig. 5.10 ends at 0.8 m/s^2; the filtered peaks are those of Fig. 5.9."""
    measures = done.measures
    assert measures.acceleration_window_max.max() < 0.8
    assert measures.acceleration_window_max[2] <= 0.35
    assert measures.acceleration_rms.max() <= 0.15
    assert 5.0 < measures.acceleration_peak.max() < 10.0
    assert measures.clipped_share <= 0.001


def test_processed_as_in_the_thesis_it_has_the_level_of_the_figure(found):
    window = found["processed as in the thesis"].acceleration_window_max
    assert ((window[:2] >= 0.15) & (window[:2] <= 0.8)).all()
    assert window[2] <= 0.35


def test_the_acceleration_error_is_smallest_in_z_and_largest_in_the_fast_part(done, found):
    comparison, motion = done.evaluation.comparison, done.prepared.motion
    error = {
        speed: rms(comparison.acceleration_error[under_way(motion, comparison.time, speed)])
        for speed in (0.5, 1.0, 5.0)
    }
    total = {speed: np.linalg.norm(of_part) for speed, of_part in error.items()}
    assert total[1.0] > 1.5 * total[0.5]
    assert total[5.0] >= 3.0 * total[0.5]
    thesis = found["processed as in the thesis"]
    for measures in (done.measures, thesis):
        largest = measures.acceleration_window_time[:2]
        assert under_way(motion, largest, 5.0).all()
    for measures in (done.measures, found["both"]):
        assert measures.acceleration_rms.argmin() == 2
        assert measures.acceleration_window_max.argmin() == 2


def test_alignment_order_and_elasticity_each_have_their_part_of_the_error(found):
    """Each cause switched off lowers the error; without all of them only a floor is left."""

    def total(name):
        return float(np.linalg.norm(found[name].acceleration_rms))

    assert total("sensor delays left in") > 1.15 * total("as chosen")
    assert total("both") < 0.9 * total("as chosen")
    assert total("rigid robot, both") < 0.3 * total("both")
    assert found["rigid robot, both"].acceleration_rms.max() < 0.015
    assert found["both"].angular_velocity_rms.max() < 0.006  # noise of the gyro's own included


def test_soft_gears_and_misaligned_clocks_raise_the_error_alike(done):
    """A level of error is no evidence of either: agreement with 0.8 m/s^2 validates nothing."""
    soft = load_model(variant(assets.IRB1400_XML, gear_stiffness=0.19))
    job = VirtualRobot(soft).load(done.prepared.motion.phi)
    measures = run_one(ImuExperimentCfg(), replace(done.prepared, job=job), seed=0).measures
    assert measures.acceleration_window_max.max() > 2 * done.measures.acceleration_window_max.max()
    late = replace(ImuExperimentCfg(), accelerometer_delay=25.0)
    cell = CELLS["irb1400"]
    misaligned = evaluate(done.run, cell.robot, cell.with_imu, processing(late))
    error = rms(misaligned.comparison.acceleration_error)
    assert np.linalg.norm(error) > 2 * np.linalg.norm(done.measures.acceleration_rms)


def test_clocks_are_synchronised_to_a_millisecond(done):
    """Twenty IMU individuals on one run, offsets up to 0.4 s, the filter's delay removed."""
    recording, cell, cfg = done.run.recording, CELLS["irb1400"], processing(ImuExperimentCfg())
    error = []
    for seed in range(20):
        rng = np.random.default_rng(1000 + seed)
        imu, truth = draw(ImuCfg(clock_offset=0.4), rng), recording.truth
        samples = imu.measure(truth.time, truth.imu_acceleration, truth.imu_angular_velocity, rng)
        offset = find_offset(samples, recording.time, recording.motor_angle, cell.with_imu, cfg)
        error.append(offset - imu.clock_offset)
    assert np.std(error) < 0.3e-3
    assert np.abs(error).max() < 1e-3


def test_the_tool_is_a_millimetre_from_where_the_motors_say(done):
    assert 0.2e-3 < done.measures.tool_distance < 2e-3
    assert done.measures.loop_error < 1e-6
    rigid = ImuExperimentCfg(flexibility="rigid")
    measures = run_one(rigid, prepare(rigid)[0], seed=0).measures
    encoder = 2 * np.pi / 4095 / 50 * 1.5  # [m], a count of the coarsest axis on 1.5 m
    assert measures.tool_distance < encoder


# The other motions and the other robot


@pytest.mark.parametrize(("servo", "low", "high"), [("feedforward", 0, 2e-4), ("pid", 2e-4, 1e-3)])
def test_idle_motors_are_pushed_less_with_feedforward(servo, low, high):
    """Without it the wrist, with its large friction and small inertia, comes nearest to 5e-4."""
    cfg = ImuExperimentCfg(motion="sequential", servo=servo)
    runs = [run_one(cfg, one, seed=0).measures for one in prepare(cfg)]
    assert low < np.nanmax([measures.idle_peaks for measures in runs]) < high
    assert max(measures.loop_error for measures in runs) < 1e-6


def test_a_stopped_motor_creeps_by_noise_and_integral_and_sticks_without():
    """What moves idle motors is their own stop, not the others: the root of the peaks of 5.3.2."""
    cfg = ImuExperimentCfg(motion="sequential")
    wrist = prepare(cfg)[1]
    mj = copy.copy(wrist.job.model.mj)
    axes = [mj.actuator(f"axis_{i}").id for i in range(1, 7)]
    mj.actuator_gainprm[axes, KI] *= 1e-6
    drives = replace(wrist.job.model.drives, torque_noise=0.0, encoder_noise=0.0)
    model = replace(wrist.job.model, mj=mj, drives=drives)
    stuck = replace(wrist, job=replace(wrist.job, model=model))
    count = 2 * np.pi / 4095 / 50
    assert np.nanmax(run_one(cfg, stuck, seed=0).measures.idle_peaks) < 1.01 * count
    assert np.nanmax(run_one(cfg, wrist, seed=0).measures.idle_peaks) > 4 * count


def test_idle_peaks_are_what_others_moves_do_to_a_resting_motor():
    time = np.arange(100) * 0.004
    reference = np.zeros((100, 6))
    reference[20:40, 0] = np.linspace(0.0, 0.1, 20)
    reference[40:, 0] = 0.1
    angle = reference.copy()
    angle[30, 1] = 3e-4
    angle[80, 1] = 9e-4  # nobody moves
    zeros = np.zeros((100, 6))
    recording = Recording(
        time=time,
        reference=reference,
        correction=zeros,
        motor_angle=angle,
        motor_torque=zeros,
        truth=nothing_happens(time),
    )
    peaks = idle_peaks(recording)
    assert np.isnan(peaks[0])
    assert peaks[1:] == pytest.approx([3e-4, 0, 0, 0, 0])


def nothing_happens(time):
    shapes = {
        "gear_angle": 6,
        "spring_angle": 6,
        "motor_torque": 6,
        "tool_position": 3,
        "tool_quaternion": 4,
        "imu_acceleration": 3,
        "imu_angular_velocity": 3,
        "qpos": 6,
    }
    return Truth(time=time, **{name: np.zeros((len(time), n)) for name, n in shapes.items()})


def test_the_large_robot_predicts_its_imu_too():
    table = imu_large([0])
    assert [verdict for verdict in table.verdicts if not verdict.holds] == []


def test_rest_tells_motors_off_from_motors_on():
    _, rest = run_rest(ImuExperimentCfg(motion="rest", off=4.0, on=6.0), seed=0)
    assert ((rest.off_rms > 0.009) & (rest.off_rms < 0.014)).all()
    assert (rest.on_rms[1:] > 3.0 * rest.off_rms[1:]).all()
    assert ((rest.on_level[1:] > 0.15) & (rest.on_level[1:] < 0.45)).all()


def test_the_power_spectrum_is_welch_s():
    signal = np.random.default_rng(0).standard_normal((1500, 3))
    frequency, density = power_spectrum(signal, 100.0)
    expected = welch(signal, 100.0, window="hann", nperseg=200, axis=0)
    assert frequency == pytest.approx(expected[0])
    assert density == pytest.approx(expected[1], rel=1e-9)


# The command


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "imu"
    assert main(["imu", "--out", str(out), "--quiet"]) == 0
    return out


def test_a_run_leaves_its_files(folder):
    files = {"summary.json", "signals.parquet", "imu.parquet", "replay.rrd"} | FIGURES
    assert {file.name for file in folder.iterdir()} == files


def test_the_summary_can_be_computed_again_from_the_signals(folder):
    (row,) = json.loads((folder / "summary.json").read_text())["experiments"]
    table = pq.read_table(folder / "imu.parquet")
    late = table["time"].to_numpy() >= row["since"]

    def columns(name):
        return np.stack([table[f"{name}_{axis}"].to_numpy()[late] for axis in "xyz"], axis=1)

    error = columns("acceleration_measured") - columns("acceleration_predicted")
    assert rms(error) == pytest.approx(row["acceleration_rms"], rel=1e-12)
    peaks = columns("acceleration_error_rms").max(axis=0)
    assert peaks == pytest.approx(row["acceleration_window_max"], rel=1e-12)
    assert table.schema.field("imu_acceleration_x").metadata == {b"unit": b"m/s^2"}
    (run,) = read_signals(folder / "signals.parquet").runs
    assert idle_peaks(run.recording) == pytest.approx(
        [np.nan if p is None else p for p in row["idle_peaks"]], nan_ok=True
    )


def test_the_replay_holds_the_robot_and_both_sides_of_the_comparison(folder):
    from rerun.chunk import RrdReader

    table = pq.read_table(folder / "imu.parquet")
    entities, series = set(), {}
    for chunk in RrdReader(folder / "replay.rrd").stream().to_chunks():
        entities.add(chunk.entity_path)
        batch = chunk.to_record_batch()
        names = {name.split(":")[-1]: name for name in batch.schema.names}
        if "scalars" in names and not chunk.is_static:
            series[chunk.entity_path] = np.ravel(batch.column(names["scalars"]).to_pylist())
    assert {"/robot/rod", "/robot/crank", "/robot/disc", "/robot/path"} <= entities
    for side in ("measured", "predicted"):
        expected = table[f"acceleration_{side}_z"].to_numpy()
        assert series[f"/acceleration_z/{side}"] == pytest.approx(expected, abs=0)


@pytest.mark.parametrize("motion", ["sequential", "rest"])
def test_the_other_motions_leave_their_figures(motion, tmp_path):
    options = ["--off", "4", "--on", "4"] if motion == "rest" else []
    assert main(["imu", "--motion", motion, *options, "--out", str(tmp_path / "x"), "--quiet"]) == 0
    names = {file.name for file in (tmp_path / "x").glob("*.png")}
    if motion == "rest":
        assert names == {"rest.png", "spectrum.png"}
    else:
        assert len(names) == 2 * len(FIGURES)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[program]]\ndo = "MoveX"\nto = { motors = [0,0,0,0,0,0] }\nspeed = 100\n', "line 2"),
        ('[[program]]\ndo = "MoveJ"\nto = { position = [3000, 0, 0] }\nspeed = "50 %"\n', "line 1"),
        ('[[program]]\ndo = "MoveJ"\nto = { motors = [9,0,0,0,0,0] }\nspeed = 0\n', "line 4"),
        (
            '[[program]]\ndo = "MoveJ"\nto = { motors = [0,-10,65,0,0,0] }\nspeed = "50 %"\n',
            "motor 3 - motor 2",
        ),
        (
            '[[program]]\ndo = "MoveJ"\nto = { motors = [0,75,0,0,0,0] }\nspeed = "50 %"\n',
            "motor 2",
        ),
        (
            '[[program]]\ndo = "MoveC"\nvia = { position = [900, 0, 1195] }\n'
            "to = { position = [850, 0, 1195] }\nspeed = 100\n",
            "one line",
        ),
    ],
)
def test_a_bad_program_is_bad_input(text, words, tmp_path, capsys):
    """Unknown instruction, out of reach, zero speed, the linkage's range, a joint limit, a line."""
    program = tmp_path / "bad.toml"
    program.write_text(text)
    out = tmp_path / "out"
    assert main(["imu", "--program", str(program), "--out", str(out)]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "bad.toml" in complaint
    assert words in complaint
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--program", "missing.toml"], "missing.toml"),
        (["--robot", "large", "--motion", "sequential"], "simultaneous"),
        (["--robot", "large", "--motion", "rest"], "brakes"),
        (["--cutoff", "60"], "below 50 Hz"),
        (["--accelerometer-delay", "-1"], ">= 0 ms"),
        (["--motion", "rest", "--on", "1"], "at least 3 s"),
    ],
)
def test_bad_options_are_bad_input(options, words, tmp_path, capsys):
    assert main(["imu", *options, "--out", str(tmp_path / "out")]) == 2
    assert words in capsys.readouterr().err


def test_a_run_is_one_rollout(monkeypatch):
    """No Python in the step loop: `armside bench imu` has the seconds that this saves."""
    calls = []
    rollout = Rollout.rollout
    monkeypatch.setattr(Rollout, "rollout", lambda *a, **k: calls.append(1) or rollout(*a, **k))
    prepare(ImuExperimentCfg())[0].job.run(rng=np.random.default_rng(0))
    assert len(calls) == 1


@pytest.mark.parametrize("claim", ["imu", "imu_causes", "rest"])
def test_every_statement_of_a_claim_holds_on_one_seed_of_it(claim):
    """`armside verify` runs the same functions over all their seeds."""
    table = getattr(verify_irb1400, claim)([0])
    assert [verdict.statement for verdict in table.verdicts if not verdict.holds] == []


def test_a_run_costs_little_more_than_its_physics():
    """1.3 times a bare rollout, taken in turns; the margin is for a machine that others use too."""
    job = prepare(ImuExperimentCfg())[0].job
    run, bare = interleaved([bench_imu.run_of(job), bench_imu.bare_rollout_of(job)], repeats=5)
    assert run / bare < 1.5
