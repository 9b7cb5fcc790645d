"""`armside gears` on a folder of tables."""

import json

import numpy as np
import pytest

from armside.kinematics import Limits, Link, Robot, compile, read_gear_error, robot_toml

ARM = Robot((Link(d=0.3, alpha=np.pi / 2), Link(a=0.5), Link(a=0.4)), name="three joints")
LIMITS = Limits(lower=(-3.0,) * 3, upper=(3.0,) * 3, speed=(3.0,) * 3)


@pytest.fixture
def folder(tmp_path):
    """Tables of a tracker that sees the second joint's error of 100 urad."""
    time = np.arange(0.0, 20.0, 0.005)
    phi = np.column_stack([np.sin(0.6 * time), 0.5 + np.sin(0.4 * time), np.cos(0.5 * time)])
    output = phi.copy()
    output[:, 1] -= 1e-4 * np.sin(100.0 * phi[:, 1] + 1.0)
    noise = np.random.default_rng(0).normal(0.0, 5e-6, (len(time), 3))
    tool = compile(ARM).pose(output)[:, :3, 3] + noise
    made = tmp_path / "tables"
    made.mkdir()
    for name, values, columns in (
        ("encoders", phi, [f"motor_angle_{i}" for i in (1, 2, 3)]),
        ("tracker", tool, [f"target_{axis}" for axis in "xyz"]),
    ):
        header = ",".join(["time", *columns])
        rows = np.column_stack([time, values])
        np.savetxt(made / f"{name}.csv", rows, "%.12g", ",", header=header, comments="")
    (tmp_path / "arm.toml").write_text(robot_toml(ARM, LIMITS))
    return made


def test_summary_tables_and_files(armside, tmp_path, folder):
    line = f"gears {folder} --robot {tmp_path / 'arm.toml'} --largest-order 150"
    status, out, err = armside(f"{line} --out {tmp_path / 'out'}")
    assert (status, err) == (0, "")
    assert max(len(text) for text in out.splitlines() if not text.startswith("Results")) <= 80
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    (term,) = summary["joints"][1]["terms"]
    assert abs(term["order"] - 100.0) < 0.5
    assert term["amplitude_interval"][0] < 1.05e-4
    assert term["amplitude_interval"][1] > 0.95e-4
    assert summary["orders"] == [round(term["order"], 2)]
    assert summary["judged"][0]["learned_from"] == ["first half of tables"]
    assert (
        summary["judged"][0]["tool"]["pooled"] < 0.7 < summary["judged"][0]["sham_tool"]["pooled"]
    )
    assert summary["judged"][0]["unjudged"] is None
    files = {file.name for file in (tmp_path / "out").iterdir()}
    tables = {"summary.json", "gears.toml", "robot.toml"}
    assert files == tables | {"scan.png", "tool.png", "fused.png"}
    (stated,) = read_gear_error(tmp_path / "out" / "robot.toml")
    assert (stated.joint, stated.order) == (2, term["order"])
    assert (stated.amplitude, stated.phase) == (term["amplitude"], term["phase"])
