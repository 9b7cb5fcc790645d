"""`armside convert` on recordings and logs, and bags given to the commands."""

import json
import os

import numpy as np
import pytest

from armside.kinematics import CATALOGUE, compile
from armside.sim.recordings import MotionRecording, Stream, read_motion
from armside.sim.recordings.bags.write import write_bag
from armside.sim.records.tables import read_table

TIME = np.arange(0.0, 4.0, 0.02)
PHI = np.column_stack([np.sin(TIME), np.cos(TIME)])
POINTS = np.column_stack([np.cos(TIME), np.sin(TIME), TIME])
ONE = MotionRecording(name="x", encoders=Stream(TIME, PHI), tracker=Stream(TIME, POINTS), form="")
LOG = "timestamp,cmdnum,J1,J2\n0,1,10,20\n0.004,1,10.5,21\n"


@pytest.fixture
def bag(tmp_path):
    write_bag(tmp_path / "bag", ONE)
    return tmp_path / "bag"


def test_a_bag_becomes_tables_and_tables_a_bag(armside, summary_of, bag, tmp_path):
    source = bag
    for kind in ("csv", "parquet", "mcap"):
        found = summary_of(f"convert {source} --to {kind} --file {tmp_path / kind}")
        assert found["samples"] == {"encoders": 200, "tracker": 200}
        assert found["form"] == ("ROS bag" if source == bag else "folder of tables")
        back = read_motion(source := tmp_path / kind)
        assert back.tracker is not None
        np.testing.assert_array_equal(back.encoders.values, PHI)
        np.testing.assert_array_equal(back.tracker.values, POINTS)
        np.testing.assert_allclose(back.encoders.time, TIME, rtol=0.0, atol=2e-9)
    assert armside(f"convert {bag} --to mat").status == 0
    assert sorted(file.name for file in (tmp_path / "bag-mat").iterdir()) == [
        "encoders.mat",
        "tracker.mat",
    ]


def test_a_log_becomes_a_table(armside, tmp_path):
    (tmp_path / "abb.csv").write_text(LOG)
    status, out, _ = armside(f"convert {tmp_path / 'abb.csv'} --to parquet")
    assert status == 0
    assert "ABB, log of a RAPID task, 2 axes" in out
    table = read_table(tmp_path / "abb-signals.parquet")
    np.testing.assert_allclose(table["motor_angle_2"], np.radians([20.0, 21.0]))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("convert bag --to csv --file full", "full is not empty"),
        ("convert bag --joint-topic /x", "has no topic /x"),
        ("convert bag --columns abb.csv", "--columns is of those"),
        ("convert abb.csv --joints a", "topics and joints are chosen in bags"),
        ("convert abb.csv --to mat --file a.csv", "mat files end with .mat"),
        ("convert abb.csv --columns abb.csv", "abb.csv cannot be read"),
        ("convert half.mcap", "half.mcap"),
        ("convert fifo.mcap", "is no regular file"),
        ("convert big.mcap", "big.mcap"),
        ("gears half.mcap --robot ur10", "half.mcap"),
        ("gears bag --robot ur10", "has 6 motors, the recording has 2"),
        ("gears --robot large --joints a b", "joints is of recordings in bags"),
        ("imu --joints a b", "joints needs --recordings"),
        ("imu --recordings bag --robot ur10 --imu-topic /target", "--imu-topic takes"),
        ("calibrate-arm half.mcap --robot ur10", "half.mcap"),
        ("calibrate-arm bag --robot ur10", "no target was seen while the arm stood still"),
        ("calibrate-arm abb.csv --robot ur10 --tracker-topic /x", "is no bag"),
    ],
)
def test_bad_input_is_one_line(bad_input, bag, tmp_path, line, said):
    (tmp_path / "abb.csv").write_text(LOG)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "x").write_text("")
    whole = (bag / "bag.mcap").read_bytes()
    (tmp_path / "half.mcap").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "big.mcap").touch()
    with open(tmp_path / "big.mcap", "wb") as file:
        file.truncate(3_000_000_000)
    os.mkfifo(tmp_path / "fifo.mcap")
    bad_input(line, said)


def test_calibrate_arm_reads_a_bag(armside, tmp_path):
    """Sixty stands of a UR10; what is calibrated is the nominal robot."""
    rng = np.random.default_rng(0)
    poses = rng.uniform(-2.0, 2.0, (60, 6))
    time = np.arange(0.0, 60.0, 0.05)
    knots = np.ravel([[k, k + 0.7] for k in range(60)])
    phi = np.column_stack([np.interp(time, knots, np.repeat(q, 2)) for q in poses.T])
    at = np.arange(60, dtype=np.float64) + 0.35
    points = compile(CATALOGUE["ur10"].robot).pose(poses)[:, :3, 3] + rng.normal(0.0, 1e-4, (60, 3))
    one = MotionRecording(name="x", encoders=Stream(time, phi), tracker=Stream(at, points), form="")
    write_bag(tmp_path / "ur10", one)
    line = f"calibrate-arm {tmp_path / 'ur10'} --robot ur10 --harmonics 0 --next 0 --json"
    status, out, err = armside(f"{line} --out {tmp_path / 'out'}")
    assert (status, err) == (0, "")
    summary = json.loads(out)
    assert summary["held_out"]["nominal"]["mean"] < 3e-4
    assert "60 poses at which the arm stood still and a target was seen" in summary["notes"]
