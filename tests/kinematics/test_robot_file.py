"""Robot files: what is written is read back, and what cannot be a robot is named."""

import os

import numpy as np
import pytest

from armside.kinematics import CATALOGUE, LARGE_ROBOT, Convention, Joint, compile, robot_toml
from armside.kinematics.robot_file import (
    LARGEST,
    GearTerm,
    gear_toml,
    read_gear_error,
    read_gear_file,
    read_robot,
)

SCARA = """
name = "scara"
convention = "modified"
offset = [0, 0, "-pi/2", 0]
coupling = [[1, 0, 0, 0], [-1, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
[[link]]
d = 0.3
[[link]]
a = 0.4
[[link]]
a = 0.25
alpha = "pi"
[[link]]
joint = "prismatic"
[[link]]
theta = "pi/2"
joint = "fixed"
[limits]
lower = [-2, -2.5, -6, 0]
upper = [2, 2.5, 6, 0.2]
speed = [6, 6, 20, 1]
"""


@pytest.mark.parametrize("name", CATALOGUE)
def test_a_written_robot_is_read_back_equal(name, tmp_path):
    robot, limits = CATALOGUE[name]
    (file := tmp_path / "arm.toml").write_text(robot_toml(robot, limits))
    again = read_robot(file)
    assert again.limits == limits
    np.testing.assert_array_equal(again.robot.coupling, robot.coupling)
    np.testing.assert_array_equal(again.robot.offset, robot.offset)
    for ours, theirs in zip(again.robot.links, robot.links, strict=True):
        assert (ours.theta, ours.d, ours.a, ours.alpha) == pytest.approx(
            (theirs.theta, theirs.d, theirs.a, theirs.alpha), abs=0
        )
        assert ours.joint is theirs.joint


def test_a_file_holds_any_serial_arm(tmp_path):
    (file := tmp_path / "scara.toml").write_text(SCARA)
    robot, limits = read_robot(file)
    assert robot.convention is Convention.MODIFIED
    assert [link.joint for link in robot.links[-2:]] == [Joint.PRISMATIC, Joint.FIXED]
    assert robot.offset[2] == -np.pi / 2
    assert limits.upper[3] == 0.2
    assert compile(robot).pose(np.zeros(4)).shape == (4, 4)


WRONG = {
    "": "needs at least one [[link]]",
    "[[link]]\nlength = 1": "link 1 has the unknown key 'length'; keys: theta, d, a, alpha, joint",
    "colour = 'red'\n[[link]]": "the file has the unknown key 'colour'",
    "[[link]]\nd = true": "link 1: d must be a number, got True",
    "[[link]]\nd = inf": "link 1: d must be a number below 1e6, got inf",
    "[[link]]\nalpha = 'pi/x'": "text such as '-pi/2', got 'pi/x'",
    "[[link]]\njoint = 'ball'": "link 1: joint must be one of revolute, prismatic, fixed",
    "offset = [0, 0]\n[[link]]": "offset must have shape (1,) for 1 moving links, got (2,)",
    "coupling = [[0]]\n[[link]]": "coupling must be invertible",
    "[[link]]\n[limits]\nlower = [1]\nupper = [-1]": "lower must be below upper",
    "[[link]]\n[limits]\nspeed = [1, 1]": "limits: speed must have 1 numbers, got 2",
    "[[link]]\njoint = 'fixed'": "needs at least one link that is not fixed",
    "name = 7\n[[link]]": "name must be printable text",
    "[[link]": "Expected",
    "x = " + "[" * 5000: "",
    "#" * (LARGEST + 1): f"at most {LARGEST} bytes",
}


@pytest.mark.parametrize("text", WRONG, ids=range(len(WRONG)))
def test_what_is_no_robot_is_named_in_one_line(text, tmp_path):
    (file := tmp_path / "arm.toml").write_text(text)
    with pytest.raises(ValueError, match=r"^arm\.toml: ") as error:
        read_robot(file)
    assert WRONG[text] in str(error.value)
    assert "\n" not in str(error.value)


def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "arm.toml")
    with pytest.raises(ValueError, match="is no regular file"):
        read_robot(tmp_path / "arm.toml")


# Zero poses by hand from the data sheets: the UR10 lies stretched along -x, the IRB120 stands with
# its forearm forward.
ZERO_POSITIONS = {"ur10": (-1.1843, -0.256141, 0.0116), "irb120": (0.374, 0.0, 0.630)}


@pytest.mark.parametrize("name", ZERO_POSITIONS)
def test_the_flange_stands_in_the_zero_pose_of_the_data_sheet(name):
    T = compile(CATALOGUE[name].robot).pose(np.zeros(6))
    np.testing.assert_allclose(T[:3, 3], ZERO_POSITIONS[name], rtol=0, atol=1e-12)


def test_gear_error_is_written_and_read_back(tmp_path):
    terms = (GearTerm(1, 240.0, 1.2e-4, 2.6), GearTerm(6, 202.5, -3e-5, 0.1))
    (tmp_path / "arm.toml").write_text(robot_toml(*CATALOGUE["ur10"], terms))
    assert read_gear_error(tmp_path / "arm.toml") == terms
    assert read_robot(tmp_path / "arm.toml").robot.n_joints == 6


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("joint = 7\norder = 1\namplitude = 0\nphase = 0", "joint must be 1 to 6, got 7"),
        ("joint = 1\norder = 1\namplitude = 0", "gear_error 1 lacks phase"),
        ("joint = 1\norder = 1\namplitude = 0\nphase = 0\nx = 1", "unknown key 'x'"),
    ],
)
def test_wrong_gear_error_is_named(tmp_path, row, said):
    text = robot_toml(*CATALOGUE["ur10"])
    (tmp_path / "arm.toml").write_text(f"{text}\n[[gear_error]]\n{row}\n")
    with pytest.raises(ValueError, match=said):
        read_robot(tmp_path / "arm.toml")


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
