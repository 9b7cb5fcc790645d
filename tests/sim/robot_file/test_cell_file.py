"""Robot files: read, refused with file and field, and equal for both robots of the thesis."""

import re
import shutil
from dataclasses import fields

import numpy as np
import pytest

from armside import assets
from armside.kinematics import CATALOGUE, robot_toml
from armside.kinematics.codegen.robot_xml import urdf
from armside.sim.cell import CELLS
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot_file.find import find_cell, load_robot, read_cell

FOLDER = assets.LARGE_ROBOT_XML.parent
ROUNDING = 1e-15
"""A few units in the last place of numbers near 1: processors round a length, and a product with
pi, in another order."""
TWO_LINK = FOLDER / "two_link.toml"


@pytest.mark.parametrize("name", CELLS)
def test_the_file_of_a_robot_of_the_thesis_is_its_cell(name):
    file = CELLS[name].xml.with_suffix(".toml")
    read, cell = read_cell(file), CELLS[name]
    same = [field.name for field in fields(read) if field.name not in ("poses", "limits")]
    for field in same:
        assert getattr(read, field) == getattr(cell, field), field
    assert read.poses.keys() == cell.poses.keys()
    for key, pose in read.poses.items():
        assert pose.position == cell.poses[key].position
        assert pose.quaternion == pytest.approx(cell.poses[key].quaternion, abs=ROUNDING)
    for field in ("lower", "upper", "speed"):
        own = getattr(cell.limits, field)
        assert getattr(read.limits, field) == pytest.approx(own, abs=ROUNDING)
    assert read.limits.coupled == cell.limits.coupled


def test_a_robot_is_found_by_name_or_by_file():
    assert find_cell("large") is CELLS["large"]
    assert find_cell(str(TWO_LINK)).robot.n_joints == 2
    with pytest.raises(ValueError, match=r"Unknown robot 'scara'\. Robots: large, irb1400, or a"):
        find_cell("scara")


def test_kinematics_are_found_by_name_and_by_file_of_any_kind(tmp_path):
    assert load_robot("ur10").arm is CATALOGUE["ur10"]
    arm = load_robot(str(TWO_LINK)).arm
    (tmp_path / "arm.toml").write_text(robot_toml(*arm), encoding="utf-8")
    (tmp_path / "arm.urdf").write_text(urdf(*arm), encoding="utf-8")
    for file in ("arm.toml", "arm.urdf", "arm.urdf#link_2", "arm.urdf#base_link:tool0"):
        assert load_robot(f"{tmp_path / file}").arm.robot.n_joints == 2
    with pytest.raises(ValueError, match=r"Unknown robot 'ur11'.*ur10.*robot file"):
        load_robot("ur11")


def test_masses_are_those_of_the_hardware_where_they_are_asked_for():
    assert load_robot("large").bodies == ()
    assert len(load_robot("large", masses=True).bodies) == len(CELLS["large"].robot.links)
    assert load_robot("ur10", masses=True).bodies == ()


def test_a_urdf_in_place_of_the_links_gives_the_same_geometry(tmp_path):
    """Written from the table, named in the file: the model is held to it as to the table."""
    arm = load_robot(str(TWO_LINK)).arm
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


TEXT = assets.LARGE_ROBOT_XML.with_name("scara.toml").read_text(encoding="utf-8")
BODY = "[[body]]\nmass = 1\ncentre = [0, 0, 0]\ninertia = [1, 1, 1]\n"
HINGE = '[[structure]]\nname = "a"\nlink = {}\ndirection = [{}, 0, 0]\nstiffness = 1e5\n'
DOWN, SIX = "quaternion = [0, 1, 0, 0]", "inertia = [0.001, 0.001, 0.001]"


def more(text):
    """Further tables in a file, before that of the tool."""
    return "[tool]", f"{text}\n[tool]"


WRONG = [
    ("mass = 20", "mass = 0", "hardware: mass must be a finite number > 0 kg, got 0"),
    ("mass = 20", "mass = 1e300", r"hardware: mass must .* and <= 1e\+12 kg, g"),
    ("[drives]", "[drives]\ngear = 3", "drives has the unknown key 'gear'; keys: g"),
    ("[drives]", "[drive]", "the file has the unknown key 'drive'; keys: name,"),
    ("[50, 50,", "[50,", "drives: gear_ratio must have 4 numbers or one numb"),
    ("[50, 50,", '["high", 50,', "drives: gear_ratio must be a number or text such as"),
    ("lower = [-2.2,", "lower = [2.3,", "limits: lower must be below upper, got 2.3 and"),
    (
        *(SIX, "inertia = [0.001, 0.001, 0.01]"),
        "tool: inertia must have principal moments above 0 of which none exceeds the sum of the ",
    ),
    (SIX, "inertia = [0, 0.001, 0.001]", "tool: inertia must have principal moments"),
    (SIX, "inertia = [0.001]", "tool: inertia must be 3 or 6 numbers"),
    ("centre = [0, 0, 0.03]", "centre = [0, 0]", "tool: centre must be a list of 3 num"),
    ("[drives]", BODY + "[drives]", "body must be 4 tables, one for each moving link, g"),
    (
        *more("[gears]\nstiffness = 3\nfrequency = 10"),
        "gears: give stiffness or frequency, not both",
    ),
    (
        *("[drives]", "[drives]\nstatic_friction = 1\ncoulomb_friction = 2"),
        "drives: static_friction must be >= coulomb_friction, got 1 and 2 N m on axis 1",
    ),
    (*more('[[structure]]\nname = "a"'), "structure 1 lacks link, direction,"),
    (*more(HINGE.format(5, 1)), r"structure 1: link must be 0 \(base\) to 4, got 5"),
    (*more(HINGE.format(1, 0)), "structure 1: direction must not be zero"),
    (
        *more("[gears]\nrigid = true\n[effects]\nlost_motion = 1e-5"),
        "effects: lost_motion needs gears with springs",
    ),
    (*more("[effects]\ntorque_ripple = 1"), "effects: torque_ripple must h"),
    (
        *more("[effects]\ngear_temperature = 20"),
        "effects: gear_temperature must be a finite number >= 26 and <= 80 deg C, got 20",
    ),
    (*more("[effects]\nsoft_stiffness = 1e4"), "effects: soft_stiffness needs lost_motion"),
    ("speed = [7,", "speed = [0,", "limits: speed must be > 0, got 0 on axis 1"),
    ('name = "SCARA"', 'name = "SCARA"\nmodel = "a.xml"', "model has the hardware: leave"),
    (
        *(DOWN, "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]"),
        "pose p3: rotation must be right-handed, got a reflection",
    ),
    (
        *(DOWN, "rotation = [[1, 0, 0], [0, 1, 0], [0, 0.1, 1]]"),
        "pose p3: rotation must have columns of length 1 at right angles",
    ),
    (DOWN, "rotation = [[1, 0], [0, 1]]", "pose p3: rotation must be 3 rows of 3 numbers"),
    ("[pose.p1]", "[other.p1]", "the file has the unknown key 'other'"),
    ("[[link]]", "[[links]]", "the file has the unknown key 'links'; keys: name,"),
]


@pytest.mark.parametrize(("old", "new", "said"), WRONG)
def test_wrong_hardware_is_refused_in_one_line(tmp_path, old, new, said):
    assert old in TEXT
    file = tmp_path / "robot.toml"
    file.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(ValueError, match=f"^robot.toml: {said}") as refused:
        read_cell(file)
    assert "\n" not in str(refused.value)


def test_a_pose_may_be_given_as_a_rotation_matrix(tmp_path):
    file = tmp_path / "robot.toml"
    old, new = "quaternion = [0, 1, 0, 0]", "rotation = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]"
    file.write_text(TEXT.replace(old, new), encoding="utf-8")
    assert read_cell(file).poses["p3"].quaternion == pytest.approx((0, 1, 0, 0))
