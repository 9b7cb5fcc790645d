"""`armside gears` on a folder of tables."""

import json

import numpy as np
import pytest

from armside.kinematics import Limits, Link, Robot, compile, read_gear_error, robot_toml

ARM = Robot((Link(d=0.3, alpha=np.pi / 2), Link(a=0.5), Link(a=0.4)), name="three joints")
LIMITS = Limits(lower=(-3.0,) * 3, upper=(3.0,) * 3, speed=(3.0,) * 3)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Tables of a tracker that sees the second joint's error of 100 urad."""
    tmp_path = tmp_path_factory.mktemp("recorded")
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
    line = f"gears {folder} --robot {folder.parent / 'arm.toml'} --largest-order 150"
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


def test_a_found_error_is_what_moves_the_tool(armside, tmp_path, folder):
    """Output less motor angle: its sign, place and size, at the tool of the recorded angles."""
    line = f"gears {folder} --robot {folder.parent / 'arm.toml'} --largest-order 150 --json"
    joint = json.loads(armside(f"{line} --out {tmp_path / 'out'}").out)["joints"][1]
    (term,) = joint["terms"]
    assert joint["scan_peak"]["order"] == pytest.approx(term["order"], abs=0.5)
    assert (term["amplitude"], term["order"]) == pytest.approx((1e-4, 100.0), rel=0.05)
    phi = np.loadtxt(folder / "encoders.csv", delimiter=",", skiprows=1)[:, 1:]
    found, true = phi.copy(), phi.copy()
    found[:, 1] += term["amplitude"] * np.sin(term["order"] * phi[:, 1] + term["phase"])
    true[:, 1] -= 1e-4 * np.sin(100.0 * phi[:, 1] + 1.0)
    at, moved, actual = (compile(ARM).pose(angles)[:, :3, 3] for angles in (phi, found, true))
    rms = [np.sqrt(np.mean(np.sum(d**2, axis=1))) for d in (moved - at, moved - actual)]
    assert joint["tool_rms"] == pytest.approx(rms[0], rel=0.02)
    assert rms[1] < 0.2 * rms[0]
