"""Files of a gear error that was found."""

import pytest

from armside.kinematics import LARGE_ROBOT
from armside.kinematics.robot_file import GearTerm, gear_toml, read_gear_file

TERMS = (GearTerm(1, 220.03, 1.1e-5, 5.3), GearTerm(3, 242.7, 9e-6, 0.1))
DEVIATIONS = ((0.1, 5e-7, 0.05), (0.2, 6e-7, float("inf")))


@pytest.fixture
def file(tmp_path):
    made = tmp_path / "gears.toml"
    made.write_text(gear_toml(LARGE_ROBOT, TERMS, DEVIATIONS))
    return made


def test_terms_are_read_back_as_written(file):
    assert read_gear_file(file, LARGE_ROBOT) == TERMS
    assert "inf" not in file.read_text()


def test_a_robot_without_gear_error_has_no_terms(tmp_path):
    file = tmp_path / "gears.toml"
    file.write_text(gear_toml(LARGE_ROBOT, (), ()))
    assert read_gear_file(file, LARGE_ROBOT) == ()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("version = 1", "version = 2", "version must be 1, got 2"),
        ("version = 1\n", "", "is no gear-error file"),
        ('robot = "', 'robot = "other ', "is of robot 'other LARGE_ROBOT', not of 'LARGE_ROBOT'"),
        ("motors = 6", "motors = 7", "motors must be 6, got 7"),
        ("joint = 1", "joint = 7", "gear_error 1: joint must be 1 to 6, got 7"),
        ("amplitude = 1.1e-05", "amplitude = 1.1", "amplitude must be at most 0.01, got 1.1"),
        ("order = 220.03", "order = 1e5", "order must be at most 10000, got 100000"),
        ("order = 220.03", "order = nan", "order must be a number below 1e6, got nan"),
        ("phase = 5.3\n", "", "gear_error 1 lacks phase"),
        ("phase = 5.3", "phases = 5.3", "gear_error 1 has the unknown key 'phases'"),
    ],
)
def test_a_file_that_cannot_be_used_says_why(file, old, new, said):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(ValueError, match=r"gears\.toml: ") as raised:
        read_gear_file(file, LARGE_ROBOT)
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)
