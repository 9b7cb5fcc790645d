"""`signals.parquet` is read back bit for bit; an interrupted write leaves nothing."""

from dataclasses import fields, replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from armside.sim.instruments.laser_tracker import TrackerSamples
from armside.sim.records.signals import RecordedRun, read_signals, write_signals
from armside.sim.robot.drives import GearError
from armside.sim.robot.recording import Recording, Truth

CONFIG = {"pose": "p1", "speed": 0.04}


def a_recording(rng, n_log=100, step=5e-4):
    n_true = 8 * (n_log - 1) + 1

    def draw(n, width):
        return rng.normal(size=(n, width))

    widths = {"gear_angle": 6, "spring_angle": 6, "motor_torque": 6, "tool_position": 3}
    widths |= {"tool_quaternion": 4, "imu_acceleration": 3, "imu_angular_velocity": 3, "qpos": 18}
    drawn = {name: draw(n_true, width) for name, width in widths.items()}
    truth = Truth(time=np.arange(n_true) * step, **drawn)
    names = ("reference", "correction", "motor_angle", "motor_torque")
    return Recording(
        time=np.arange(n_log) * 0.004,
        truth=truth,
        limits_hit=(("torque", 3, 0.1), ("path_acceleration", 0, 1 / 3)),
        **{name: draw(n_log, 6) for name in names},
    )


def some_runs(n=3, seed=0, **size):
    rng = np.random.default_rng(seed)
    runs = []
    for k in range(n):
        recording = a_recording(rng, **size)
        time = recording.truth.time[::2].copy()
        valid = np.arange(len(time)) < len(time) - 5 * k
        position = np.where(valid[:, np.newaxis], rng.normal(size=(len(time), 3)), np.nan)
        tracker = TrackerSamples(time=time, position=position, valid=valid)
        runs.append(RecordedRun(k=k, recording=recording, tracker=tracker))
    return runs


def assert_same_bits(a, b):
    for field in fields(a):
        x, y = getattr(a, field.name), getattr(b, field.name)
        if isinstance(x, np.ndarray):
            assert x.dtype == y.dtype, field.name
            assert x.tobytes() == y.tobytes(), field.name
        elif field.name not in ("truth", "gear_error"):
            assert x == y, field.name


def test_every_array_is_read_back_bit_for_bit(tmp_path):
    runs = some_runs()
    write_signals(tmp_path / "signals.parquet", runs, config=CONFIG, seed=7)
    back = read_signals(tmp_path / "signals.parquet")
    assert (back.config, back.seed) == (CONFIG, 7)
    assert [run.k for run in back.runs] == [0, 1, 2]
    for wrote, read in zip(runs, back.runs, strict=True):
        assert_same_bits(wrote.recording, read.recording)
        assert_same_bits(wrote.tracker, read.tracker)
        truth = wrote.recording.truth
        arrays = [f.name for f in fields(truth) if f.name != "gear_error"]
        at_1000_hz = Truth(**{name: getattr(truth, name)[::2] for name in arrays})
        assert_same_bits(at_1000_hz, read.recording.truth)


def test_motor_angles_are_kept_as_the_gears_error_made_them(tmp_path):
    (run,) = some_runs(1)
    ones = np.ones((6, 1))
    gear_error = GearError(amplitude=1e-4 * ones, order=100 * ones, phase=ones)
    truth = replace(run.recording.truth, gear_error=gear_error)
    run = replace(run, recording=replace(run.recording, truth=truth))
    write_signals(tmp_path / "s.parquet", [run], config={}, seed=1, truth_rate=2000.0)
    read = read_signals(tmp_path / "s.parquet").runs[0].recording.truth
    angle = truth.gear_angle
    assert read.motor_angle == pytest.approx(angle - 1e-4 * np.sin(100 * angle + 1), abs=1e-12)
    assert np.array_equal(read.motor_angle, truth.motor_angle)
    assert np.array_equal(read.flex_angle, truth.flex_angle)
    whole = truth.gear_angle + truth.spring_angle
    assert read.motor_angle + read.flex_angle == pytest.approx(whole, abs=1e-12)


def test_the_whole_truth_can_be_kept(tmp_path):
    (run,) = some_runs(1)
    write_signals(tmp_path / "s.parquet", [run], config={}, seed=None, truth_rate=2000.0)
    back = read_signals(tmp_path / "s.parquet")
    assert_same_bits(run.recording.truth, back.runs[0].recording.truth)
    assert back.seed is None


def test_a_run_without_a_tracker_comes_back_without_one(tmp_path):
    (run,) = some_runs(1)
    write_signals(tmp_path / "s.parquet", [replace(run, tracker=None)], config={}, seed=1)
    assert read_signals(tmp_path / "s.parquet").runs[0].tracker is None


def test_a_stream_is_null_where_it_has_no_sample_and_a_lost_beam_is_not_null(tmp_path):
    runs = some_runs(2)
    write_signals(tmp_path / "s.parquet", runs, config={}, seed=1)
    table = pq.read_table(tmp_path / "s.parquet")
    rows = len(runs[0].tracker.time)
    assert table.num_rows == 2 * rows
    assert table["reference_1"].null_count == 2 * (rows - 100)
    assert table["tracker_valid"].null_count == 0
    lost = np.isnan(table["tracker_x"].to_numpy())
    np.testing.assert_array_equal(lost, ~table["tracker_valid"].to_numpy())
    assert lost.sum() == 5


def test_every_column_states_its_unit_and_the_file_its_rates(tmp_path):
    write_signals(tmp_path / "s.parquet", some_runs(1), config=CONFIG, seed=1)
    schema = pq.read_schema(tmp_path / "s.parquet")
    assert all(field.metadata[b"unit"] for field in schema)
    assert schema.field("motor_torque_3").metadata[b"unit"] == b"N m"
    assert schema.field("true_tool_position_z").metadata[b"unit"] == b"m"
    assert b'"log": 250.0' in schema.metadata[b"armside.rates"]
    assert b'"tracker": 1000.0' in schema.metadata[b"armside.rates"]


def test_the_same_data_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        write_signals(tmp_path / name, some_runs(), config=CONFIG, seed=1)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    reordered = dict(reversed(CONFIG.items()))
    write_signals(tmp_path / "d", some_runs(), config=reordered, seed=1)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "d").read_bytes()
    write_signals(tmp_path / "c", some_runs(seed=1), config=CONFIG, seed=1)
    assert (tmp_path / "a").read_bytes() != (tmp_path / "c").read_bytes()


def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    target = tmp_path / "signals.parquet"
    target.write_text("finished earlier")

    def dies_half_way(table, where, **_):
        where.write_text("half")
        raise KeyboardInterrupt

    monkeypatch.setattr(pq, "write_table", dies_half_way)
    with pytest.raises(KeyboardInterrupt):
        write_signals(target, some_runs(1), config={}, seed=1)
    assert [p.name for p in tmp_path.iterdir()] == ["signals.parquet"]
    assert target.read_text() == "finished earlier"


def test_clocks_that_nearly_agree_are_refused(tmp_path):
    (run,) = some_runs(1)
    askew = replace(run.tracker, time=run.tracker.time + 1e-12)
    with pytest.raises(ValueError, match="one grid of time"):
        write_signals(tmp_path / "s", [replace(run, tracker=askew)], config={}, seed=1)


def test_an_iteration_twice_is_refused(tmp_path):
    (run,) = some_runs(1)
    with pytest.raises(ValueError, match=r"different k, got k = \[0, 0\]"):
        write_signals(tmp_path / "s", [run, run], config={}, seed=1)
    with pytest.raises(ValueError, match="one or more runs"):
        write_signals(tmp_path / "s", [], config={}, seed=1)


def test_a_foreign_file_is_named(tmp_path):
    pq.write_table(pa.table({"a": [1]}), tmp_path / "foreign.parquet")
    with pytest.raises(ValueError, match=r"foreign\.parquet holds no signals of armside"):
        read_signals(tmp_path / "foreign.parquet")
