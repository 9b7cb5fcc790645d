"""Robot files: read, refused with file and field, and equal for both robots of the thesis."""

import re
import shutil
from dataclasses import fields

import numpy as np
import pytest

from armside import assets
from armside.kinematics.codegen.urdf import urdf
from armside.sim.cell import CELLS
from armside.sim.cell_file import find_cell, read_cell
from armside.sim.named_robot import find_robot
from armside.sim.robot.cell_model import cell_model

FOLDER = assets.LARGE_ROBOT_XML.parent
TWO_LINK = FOLDER / "two_link.toml"


@pytest.mark.parametrize("name", CELLS)
def test_the_file_of_a_robot_of_the_thesis_is_its_cell(name):
    file = CELLS[name].xml.with_suffix(".toml")
    read = read_cell(file)
    for field in fields(read):
        assert getattr(read, field.name) == getattr(CELLS[name], field.name), field.name


def test_a_robot_is_found_by_name_or_by_file():
    assert find_cell("large") is CELLS["large"]
    assert find_cell(str(TWO_LINK)).robot.n_joints == 2
    with pytest.raises(ValueError, match=r"Unknown robot 'scara'\. Robots: large, irb1400, or a"):
        find_cell("scara")


def test_a_urdf_in_place_of_the_links_gives_the_same_geometry(tmp_path):
    """Written from the table, named in the file: the model is held to it as to the table."""
    arm = find_robot(str(TWO_LINK))
    (tmp_path / "arm.urdf").write_text(urdf(*arm))
    file = changed(tmp_path, r"(?s)\[\[link\]\].*(?=\[pose.p1\])", 'urdf = "arm.urdf"\n\n')
    read = read_cell(file)
    assert read.robot.n_joints == 2
    assert read.robot.name == arm.robot.name
    np.testing.assert_allclose(read.limits.upper, arm.limits.upper)
    cell_model(read)
    shorter = (tmp_path / "arm.urdf").read_text().replace("0.6", "0.5")
    (tmp_path / "arm.urdf").write_text(shorter)
    with pytest.raises(ValueError, match=r"two_link\.xml"):
        cell_model(read_cell(file))


def test_fewer_than_six_axes_leave_the_orientation_free_unless_it_is_held(tmp_path):
    assert read_cell(changed(tmp_path, 'orientation = "free".*\n', "")).free_rotation
    assert not read_cell(changed(tmp_path, '"free"', '"held"')).free_rotation


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('model = "two_link.xml"', "model = 3", "model must be the name of a file, got 3"),
        ('"two_link.xml"', '"none.xml"', "model must be a file, there is no"),
        ('"free"', '"loose"', "orientation must be one of held, free, got 'loose'"),
        (r"\[-0.5, 1.5\]", "[0.0]", "home must have 2 numbers, got 1"),
        (r"\[-0.5, 1.5\]", "[0, 3]", "home must be within the limits, got"),
        (r"speed = \[3, 4\]", "speed = [3]", "limits: speed must have 2 numbers, got 1"),
        (
            r"upper = \[2.6,",
            "upper = [-2.7,",
            "limits: lower must be below upper, got -2.6 and -2.7 on axis 1",
        ),
        (r"\[0.70, 0.30, 1.0\]", "[0.7, 0.3]", "pose p1: position must have 3 numbers, got 2"),
        (r"\[pose.p2\]", "[pose.p2]\nquaternion = [1, 1, 0, 0]", "pose p2: quaternion must have l"),
        ("home =", "hoem =", "the file has the unknown key 'hoem'; keys: name,"),
        (r"\ndelta = .*\n", "\n", "learning lacks delta"),
        (r"gamma = .*", "gamma = -1", "learning: gamma must be > 0, got -1"),
        (r"delta = .*", "delta = -1", "learning: delta must be a whole number of samples >= 0"),
        (r"cutoff = .*", "cutoff = 500", "learning: cutoff must be > 0 and below 125 Hz, half of"),
        ("d = 1.0", "d = 'high'", "link 1: d must be a number or text such as"),
    ],
)
def test_a_wrong_file_is_refused_with_its_name_and_field(tmp_path, old, new, said):
    file = changed(tmp_path, old, new)
    with pytest.raises(ValueError, match=f"^robot.toml: {said}") as refused:
        read_cell(file)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('mass="6"', 'mass="0"', "the body outer, which motor_2 moves, must have a mass > 0 kg"),
        ("0.01 0.125 0.125", "0.01 0.125 0.5", "inertia must satisfy A"),
        ('data="100 80"', 'data="100 -80"', "numeric gear_ratio must be above 0, got -80"),
        ('data="100 80"', 'data="100"', "numeric gear_ratio must hold 2 values, holds 1"),
        ('pos="0.6 0 0"', 'pos="0.5 0 0"', "the model is no two-link: its tool is .* off the D-H"),
        ('name="axis_2_pos"', 'name="two"', "the robot model lacks the sensor axis_2_pos"),
    ],
)
def test_a_wrong_model_is_refused_with_its_file(tmp_path, old, new, said):
    file = changed(tmp_path, "", "")
    model = tmp_path / "two_link.xml"
    text = model.read_text()
    assert old in text
    model.write_text(text.replace(old, new, 1))
    with pytest.raises(ValueError, match=said):
        cell_model(read_cell(file))


def changed(folder, old, new):
    """A copy of the file of the two-link arm and its model, with one text replaced."""
    shutil.copy(TWO_LINK.with_suffix(".xml"), folder)
    text = TWO_LINK.read_text()
    assert re.search(old, text)
    file = folder / "robot.toml"
    file.write_text(re.sub(old, new, text, count=1))
    return file
