"""`armside calibrate-arm` on the set that is part of the project."""

import ctypes
import importlib
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from armside.kinematics import compile, read_robot
from armside.kinematics.urdf import read_urdf

from .ran import ran

UR10 = Path(__file__).parents[2] / "docs/examples/ur10_tmac"
FAST = "--harmonics 0 --next 3"


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibrated") / "out"
    return ran(folder, f"calibrate-arm {UR10} --robot ur10 {FAST}"), folder


def test_table_urdf_and_c_of_the_calibrated_arm_agree(done, require_program):
    compiler = require_program("cc")
    _, folder = done
    robot, _ = read_robot(folder / "calibrated.toml")
    phi = np.random.default_rng(0).uniform(-2.0, 2.0, (20, 6))
    expected = compile(robot).pose(phi)
    by_urdf = compile(read_urdf(folder / "calibrated.urdf").robot).pose(phi)
    np.testing.assert_allclose(by_urdf, expected, atol=1e-12)
    source, library = folder / "calibrated_pose.c", folder / "calibrated_pose.so"
    subprocess.run([compiler, "-shared", "-fPIC", source, "-o", library, "-lm"], check=True)
    by_c = np.zeros_like(expected)
    function = ctypes.CDLL(str(library)).calibrated_pose
    for one, T in zip(phi, by_c, strict=True):
        function(one.ctypes.data_as(ctypes.c_void_p), T.ctypes.data_as(ctypes.c_void_p))
    np.testing.assert_allclose(by_c, expected, atol=1e-12)


def test_summary_and_files(done):
    summary, folder = done
    assert set(summary["held_out"]) == {"nominal", "geometry", "full"}
    for errors in summary["held_out"].values():
        assert 0.0 < errors["mean"] < errors["p95"] < errors["max"] < 5e-3
    assert summary["held_out"]["geometry"]["mean"] < 0.6 * summary["held_out"]["nominal"]["mean"]
    assert summary["rank"] == 27
    for row in summary["parameters"]:
        is_angle = row["name"].startswith(("alpha", "theta", "beta", "base_r", "tool_r"))
        assert row["unit"] == ("rad" if is_angle else "m"), row["name"]
    assert 0.0 < summary["smallest_singular_value"] < 1.0
    assert {"name": "d_3", "same_as": ["d_2"]} in summary["redundant"]
    robot, limits = read_robot(folder / "calibrated.toml")
    poses = np.loadtxt(folder / "next_poses.csv", delimiter=",", skiprows=1)
    assert limits.contain(poses).all()
    assert compile(robot).pose(poses).shape == (3, 4, 4)
    files = {file.name for file in folder.iterdir()}
    assert {"calibrated.urdf", "calibrated_pose.c", "residuals.png", "region.png"} <= files


def test_a_fit_that_fails_is_no_bad_input(armside, monkeypatch, tmp_path):
    def singular(*_):
        raise np.linalg.LinAlgError("Singular matrix")

    module = importlib.import_module("armside.kinematics.calibration.calibrate")
    monkeypatch.setattr(module, "fit", singular)
    status, out, err = armside(f"calibrate-arm {UR10} --robot ur10 {FAST} --out {tmp_path / 'a'}")
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert "Singular matrix" in err
    assert not list(tmp_path.iterdir())


def test_a_urdf_file_stands_for_its_robot(armside, tmp_path):
    """The export of the UR10: as many parameters as its table has can be identified."""
    from armside.kinematics import CATALOGUE
    from armside.kinematics.codegen.robot_xml import urdf

    (tmp_path / "arm.urdf").write_text(urdf(*CATALOGUE["ur10"]))
    line = f"calibrate-arm {UR10} --robot {tmp_path / 'arm.urdf'} {FAST} --json"
    status, out, err = armside(f"{line} --out {tmp_path / 'out'}")
    assert (status, err) == (0, "")
    summary = json.loads(out)
    errors = summary["held_out"]
    assert summary["rank"] == 27
    assert errors["geometry"]["mean"] < 0.6 * errors["nominal"]["mean"]
