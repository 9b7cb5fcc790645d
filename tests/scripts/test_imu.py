"""`armside imu`: its files, its summary, bad input, and the claims about it."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from armside.kinematics import robot_toml
from armside.scripts.commands.imu import ImuOptions
from armside.sim.imu.phases import idle_peaks
from armside.sim.instruments.imu import ImuCfg
from armside.sim.records.signals import read_signals

from .ran import ran

FIGURES = {
    "motor-angles.png",
    "path.png",
    "position.png",
    "angular-velocity.png",
    "acceleration.png",
    "acceleration-error.png",
}


OF_RECORDINGS = ("path", "position", "angular-velocity", "acceleration", "acceleration-error")


def rms(error):
    return np.sqrt(np.mean(error**2, axis=0))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "imu"
    ran(out, "imu")
    return out


def test_a_run_leaves_its_files(folder):
    files = {"summary.json", "signals.parquet", "imu.parquet", "replay.rrd", "robot.xml"} | FIGURES
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
    ran(tmp_path / "x", "imu --motion", motion, "--off 4 --on 4" if motion == "rest" else "")
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
def test_a_bad_program_is_bad_input(text, words, tmp_path, bad_input):
    """Unknown instruction, out of reach, zero speed, the linkage's range, a joint limit, a line."""
    (tmp_path / "bad.toml").write_text(text)
    assert "bad.toml" in bad_input("imu --program bad.toml --out out", words)


def test_the_unit_is_that_of_its_options_and_by_default_of_the_configuration():
    assert ImuOptions().experiment().imu == ImuCfg()
    assert ImuOptions(motion="rest").experiment().imu == ImuCfg(clock_offset=0.0)
    options = ImuOptions(imu_rate=200.0, gyroscope_bias=2.0, clock_offset=3.0, clock_drift=50.0)
    unit = options.experiment().imu
    assert unit.gyroscope.bias == pytest.approx(np.deg2rad(2.0))
    assert (unit.rate, unit.clock_offset, unit.clock_drift) == pytest.approx((200.0, 3e-3, 5e-5))


# Recordings of a real robot


TABLES = {
    "encoders": [f"motor_angle_{i}" for i in (1, 2, 3)],
    "imu": [f"{name}_{axis}" for name in ("acceleration", "angular_velocity") for axis in "xyz"],
    "tracker": [f"target_{axis}" for axis in "xyz"],
}


@pytest.fixture
def folders(tmp_path, scenes):
    """Tables of two days, and the robot file beside them."""
    (tmp_path / "arm.toml").write_text(robot_toml(scenes.ARM.robot, scenes.ARM.limits))
    for day in (1, 2):
        one = scenes.recording(scenes.Scene(day))
        (folder := tmp_path / f"day{day}").mkdir()
        for name, columns in TABLES.items():
            stream = getattr(one, name)
            rows = np.column_stack([stream.time, stream.values])
            header = ",".join(["time", *columns])
            np.savetxt(folder / f"{name}.csv", rows, "%.9g", ",", header=header, comments="")
    return tmp_path / "day1", tmp_path / "day2"


def test_summary_tables_and_figures_of_two_days(armside, tmp_path, folders):
    line = f"imu --recordings {folders[0]} {folders[1]} --robot {tmp_path / 'arm.toml'}"
    status, out, err = armside(f"{line} --out {tmp_path / 'out'}")
    assert (status, err) == (0, "")
    assert "of the signal [%]" in out
    assert "gyro scale 0.00" in out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["repeatability"]["mounting"] < np.radians(0.1)
    for one, day in zip(summary["recordings"], ("day1", "day2"), strict=True):
        assert one["recording"] == day
        assert np.allclose(one["constants"]["gyro_scale"], 1.02, atol=2e-3)
        assert abs(one["constants"]["gyro_offset"] - 0.1) < 1e-3
        error, signal = (one["held_out"][f"angular_velocity{end}"] for end in ("_error", ""))
        assert max(np.divide(error, signal)) < 0.02
    files = {file.name for file in (tmp_path / "out").iterdir()}
    drawn = {f"{name}-{day}.png" for name in OF_RECORDINGS for day in ("day1", "day2")}
    assert files == {"summary.json"} | drawn
