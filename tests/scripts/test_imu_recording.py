"""`armside imu --recording` on folders of tables."""

import json

import numpy as np
import pytest

from armside.kinematics import robot_toml

TABLES = {
    "encoders": [f"motor_angle_{i}" for i in (1, 2, 3)],
    "imu": [f"{name}_{axis}" for name in ("acceleration", "angular_velocity") for axis in "xyz"],
    "tracker": [f"target_{axis}" for axis in "xyz"],
}
FIGURES = ("path", "position", "angular-velocity", "acceleration", "acceleration-error")


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
    line = f"imu --recording {folders[0]} {folders[1]} --robot {tmp_path / 'arm.toml'}"
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
    drawn = {f"{name}-{day}.png" for name in FIGURES for day in ("day1", "day2")}
    assert files == {"summary.json"} | drawn


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("--recording nowhere --robot ur10", "nowhere is no folder"),
        ("--recording . --robot ur10", "no recording of a known form"),
        ("--recording . --robot ur11", "ur11"),
        ("--recording . --robot ur10 --motion rest", "--motion is of the virtual robot"),
        ("--recording . --robot ur10 --cutoff 0", "cutoff must be"),
        ("--recording . --robot ur10 --cutoff 49", "cutoff must be"),
        ("--robot ur10", "Robots: large, irb1400"),
    ],
)
def test_bad_input_is_one_line(bad_input, line, said):
    bad_input(f"imu {line}", said)
