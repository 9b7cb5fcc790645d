"""Numbers of an MJCF that no robot has are refused: MuJoCo takes them without a word."""

import re
from pathlib import Path

import pytest

from armside.assets import IRB1400_XML, LARGE_ROBOT_XML
from armside.sim.robot.mjcf import ModelError
from armside.sim.robot.model import load_model


@pytest.mark.filterwarnings("ignore")  # of MuJoCo
@pytest.mark.parametrize(
    ("text", "other", "said"),
    [
        ('mass="600"', 'mass="-600"', "mass of the body .* must be >= 0 kg, got -600"),
        ('name="gear_ratio" data="', 'name="gear_ratio" data="-', "gear_ratio must be above 0"),
        ('name="encoder_counts" data="', 'name="encoder_counts" data="-', "encoder_counts must be"),
        ('name="correction_delay" data="', 'name="correction_delay" data="-', "must be >= 0, got"),
        ('name="torque_noise" data="1e-4', 'name="torque_noise" data="nan', "must be finite"),
        ('stiffness="', 'stiffness="-', "stiffness of the joint .* must be >= 0"),
        ('damping="', 'damping="-', "damping of the joint .* must be >= 0"),
        ('armature="', 'armature="-', "armature of the joint .* must be >= 0"),
    ],
)
def test_a_number_that_no_robot_has_is_named(tmp_path, text, other, said):
    robot = Path(LARGE_ROBOT_XML).read_text(encoding="utf-8")
    assert text in robot
    (tmp_path / "robot.xml").write_text(robot.replace(text, other, 1), encoding="utf-8")
    with pytest.raises(ModelError, match=said):
        load_model(tmp_path / "robot.xml")


@pytest.mark.parametrize("file", [LARGE_ROBOT_XML, IRB1400_XML])
def test_both_robots_are_plausible_and_phases_may_be_negative(tmp_path, file):
    robot = Path(file).read_text(encoding="utf-8")
    changed = re.sub('name="gear_error_phase" data="', 'name="gear_error_phase" data="-', robot)
    (tmp_path / "robot.xml").write_text(changed, encoding="utf-8")
    load_model(tmp_path / "robot.xml")
