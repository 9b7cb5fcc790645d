"""Arms that others published, from their file to the first cut: docs/robots.md has all ten."""

import importlib.util
import json
from pathlib import Path

import pytest

from armside.scripts.cli import main

KUKA = "xacro/kuka_description"
ARMS = {
    "IRB140": ("rtbdata", "xacro/abb_irb140_description/urdf/irb140.urdf", 6),
    "KR 210": ("rtbdata", f"{KUKA}/kuka_kr210/urdf/kr210l150.urdf", 6),
    "KR 16-2": ("rtbdata", f"{KUKA}/kuka_kr16/urdf/kr16_2.urdf", 6),
    "KR 120": ("rtbdata", f"{KUKA}/kuka_kr120/urdf/kr120r2500pro.urdf", 6),
    "LBR iiwa 14": ("rtbdata", f"{KUKA}/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf", 7),
    "Puma 560": ("rtbdata", "xacro/unimation_puma560_description/urdf/puma560_robot.urdf", 6),
    "AL5D": ("rtbdata", "xacro/lynxmotion_al5d_description/urdf/al5d_robot.urdf", 4),
    "iiwa": ("robosuite", "models/assets/robots/iiwa/robot.xml", 7),
    "Panda": ("robosuite", "models/assets/robots/panda/robot.xml", 7),
    "UR5e": ("robosuite", "models/assets/robots/ur5e/robot.xml", 6),
}
WALLS = {"Puma 560", "AL5D"}
"""Their velocity limits are 0."""


def new(name, out):
    """Status of `armside robot new` on a published arm, as docs/robots.md has the line."""
    package, path, _ = ARMS[name]
    spec = importlib.util.find_spec(package)  # data alone: the package is not imported
    if spec is None or spec.origin is None:
        pytest.skip(f"{package} is not installed")
    tip = ["--tip", "right_hand"] if path.endswith(".xml") else []
    file = Path(spec.origin).parent / path
    return main(["robot", "new", str(file), *tip, "--out", str(out), "--json"])


@pytest.mark.parametrize("name", ARMS)
def test_a_published_arm_makes_a_robot_file(name, tmp_path, capsys):
    assert new(name, tmp_path / "arm") == 0
    made = json.loads(capsys.readouterr().out)
    assert made["axes"] == ARMS[name][2]
    assert bool(made["assumed"]) == (name in WALLS or ARMS[name][0] == "robosuite")


@pytest.mark.parametrize("name", ["IRB140", "Panda"])
def test_a_published_arm_is_sound_and_learns(name, tmp_path, capsys):
    assert new(name, tmp_path / "arm") == 0
    file, out = str(tmp_path / "arm" / "robot.toml"), tmp_path / "cut"
    assert main(["robot", "check", file, "--quiet"]) == 0
    words = ["laser", "--robot", file, "--iterations", "1", "--quiet", "--out", str(out)]
    assert main(words) == 0
    first, second = json.loads((out / "summary.json").read_text("utf-8"))["iterations"]
    assert second["arm_rms"] < 0.5 * first["arm_rms"]
