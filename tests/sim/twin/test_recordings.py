"""Recorded cuts in tables: what was written is what is read, whichever sensor was at the tool."""

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, prepare
from armside.sim.laser.loop import first_run
from armside.sim.notes import Cause
from armside.sim.records.files import InputError
from armside.sim.records.signals import RecordedRun, write_signals
from armside.sim.twin.recordings import measured, notes_of_first_run, read_cut

START = 3.25
"""[s], of the robot's clock at the first row."""


@pytest.fixture(scope="module")
def run():
    experiment = prepare(Cut(imu=ImuCfg()), seed=3)
    return experiment.plant.run(np.zeros_like(experiment.loaded.reference))


@pytest.fixture
def table(run):
    """Rows of the log, then rows of the IMU at its own instants."""
    log, imu = run.recording, run.imu
    columns = {"time": log.time + START}
    for name in ("reference", "motor_angle", "motor_torque"):
        values = getattr(log, name)
        columns |= {f"{name}_{i + 1}": values[:, i] for i in range(6)}
    readings = {"time": imu.time + START}
    for name in ("acceleration", "angular_velocity"):
        values = getattr(imu, name)
        readings |= {f"imu_{name}_{c}": values[:, i] for i, c in enumerate("xyz")}
    return pa.concat_tables([pa.table(columns), pa.table(readings)], promote_options="default")


def test_an_imu_is_read_on_its_own_clock(run, table, tmp_path):
    pq.write_table(table, tmp_path / "cut.parquet")
    read, expected = read_cut(tmp_path / "cut.parquet", "imu"), measured(run).imu
    assert read.imu is not None
    assert read.tool is None
    assert np.allclose(read.imu.time, expected.time, atol=1e-12, rtol=0.0)
    for name in ("acceleration", "angular_velocity", "acceleration_clipped"):
        assert np.array_equal(getattr(read.imu, name), getattr(expected, name))
    assert np.array_equal(read.motor_torque, run.recording.motor_torque)


@pytest.mark.parametrize(
    ("measure", "lost", "said"),
    [
        ("tracker", "time", "lacks the column time"),
        ("tracker", "none", "lacks the column tracker_x"),
        ("imu", "imu_acceleration_y", "lacks the column imu_acceleration_y"),
        ("imu", "imu_angular_velocity_z", "lacks the column imu_angular_velocity_z"),
    ],
)
def test_a_table_without_a_column_is_named(table, tmp_path, measure, lost, said):
    kept = [name for name in table.column_names if name != lost]
    pq.write_table(table.select(kept), tmp_path / "cut.parquet")
    with pytest.raises(InputError, match=f"cut.parquet is no recorded cut: it {said}"):
        read_cut(tmp_path / "cut.parquet", measure)


def test_lost_samples_of_an_imu_are_missing_rows(run, table, tmp_path):
    n = len(run.recording.time)
    pq.write_table(table.take([*range(n), *range(n + 4, len(table))]), tmp_path / "cut.parquet")
    read = read_cut(tmp_path / "cut.parquet", "imu")
    assert len(read.imu.time) == len(run.imu.time) - 4
    assert read.imu.time[0] == pytest.approx(run.imu.time[4], abs=1e-12)


def test_notes_of_a_run_are_those_of_its_first_iteration(tmp_path):
    experiment = prepare(Cut(speed=0.1), seed=3)
    log = first_run(experiment).recording
    hit = replace(log, limits_hit=(("torque", 2, 0.4),))
    runs = [RecordedRun(k=k, recording=recording) for k, recording in enumerate((log, hit))]
    file = tmp_path / "ours.parquet"
    write_signals(file, runs, config={}, seed=3, motion=experiment.motion)
    (note,) = notes_of_first_run(file)
    assert note.cause is Cause.SPEED


def test_lost_samples_of_a_table_are_noted(tmp_path):
    lost = pa.table({"time": [0.0, 0.004], "tracker_valid": [True, False]})
    pq.write_table(lost, tmp_path / "mine.parquet")
    (note,) = notes_of_first_run(tmp_path / "mine.parquet")
    assert note.cause is Cause.BEAM


def test_a_run_without_its_truth_is_noted_as_any_other_table(tmp_path):
    experiment = prepare(Cut(), seed=3)
    log = first_run(experiment).recording
    file = tmp_path / "ours.parquet"
    write_signals(file, [RecordedRun(k=0, recording=log)], config={}, seed=3)
    table = pq.read_table(file)
    truth = [name for name in table.column_names if name.startswith("true_")]
    for taken_out in (["k"], truth):
        pq.write_table(table.drop_columns(taken_out), file)
        assert notes_of_first_run(file) == []


def test_a_tracker_is_read_on_its_own_clock(run, table, tmp_path):
    """A target in even motion, which no low-pass changes, does so between rows of the log."""
    speed, first = np.array([0.01, -0.02, 0.03]), np.array([1.5, 0.2, 0.9])
    own = np.arange(0.0, run.recording.time[-1] + 0.01, 1e-3)
    position = first + own[:, None] * speed
    seen = {"time": own + START} | {f"tracker_{c}": position[:, i] for i, c in enumerate("xyz")}
    whole = pa.concat_tables([table, pa.table(seen)], promote_options="default")
    pq.write_table(whole, tmp_path / "cut.parquet")
    read = read_cut(tmp_path / "cut.parquet", "tracker")
    assert read.tool is not None
    steps = np.diff(read.tool, axis=0)[100:-100]  # the low-pass starts and ends at rest
    np.testing.assert_allclose(steps, np.tile(0.004 * speed, (len(steps), 1)), atol=1e-9)
    assert read.rest == pytest.approx(first, abs=5e-3)
