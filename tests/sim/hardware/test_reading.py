"""Wrong hardware in a robot file: one line with the file, the field and what is allowed."""

import pytest

from armside import assets
from armside.sim.cell_file import read_cell

TEXT = assets.LARGE_ROBOT_XML.with_name("scara.toml").read_text(encoding="utf-8")
BODY = "[[body]]\nmass = 1\ncentre = [0, 0, 0]\ninertia = [1, 1, 1]\n"

WRONG = {
    "mass zero": ("mass = 20", "mass = 0", "hardware: mass must be a finite number > 0 kg, got 0"),
    "mass NaN": ("mass = 20", "mass = nan", "hardware: mass must be a finite number > 0 kg, got"),
    "mass of a planet": (
        "mass = 20",
        "mass = 1e300",
        r"hardware: mass must .* and <= 1e\+12 kg, g",
    ),
    "mass of the tool": ("mass = 1\n", "mass = -1\n", "tool: mass must be a finite number > 0 kg"),
    "unknown key": ("[drives]", "[drives]\ngear = 3", "drives has the unknown key 'gear'; keys: g"),
    "unknown table": ("[drives]", "[drive]", "the file has the unknown key 'drive'; keys: name,"),
    "sign of a gear": ("[50, 50,", "[50, -50,", "drives: gear_ratio must be a finite number > 0"),
    "number of gears": ("[50, 50,", "[50,", "drives: gear_ratio must have 4 numbers or one numb"),
    "text": ("[50, 50,", '["high", 50,', "drives: gear_ratio must be a number or text such as"),
    "limits swapped": (
        "lower = [-2.2,",
        "lower = [2.3,",
        "limits: lower must be below upper, got 2.3 and",
    ),
    "inertia": (
        "inertia = [0.001, 0.001, 0.001]",
        "inertia = [0.001, 0.001, 0.01]",
        "tool: inertia must have principal moments above 0 of which none exceeds the sum of the ",
    ),
    "inertia zero": ("[0.001, 0.001,", "[0, 0.001,", "tool: inertia must have principal moments"),
    "size of inertia": ("[0.001, 0.001, 0.001]", "[0.001]", "tool: inertia must be 3 or 6 numbers"),
    "centre": ("centre = [0, 0, 0.03]", "centre = [0, 0]", "tool: centre must be a list of 3 num"),
    "bodies": ("[drives]", BODY + "[drives]", "body must be 4 tables, one for each moving link, g"),
    "table": ("[drives]", "body = 3\n[drives]", "the file|hardware has the unknown key 'body'"),
    "springs": ("[tool]", "[gears]\nstiffness = -3\n[tool]", "gears: stiffness must be a finite"),
    "two springs": (
        "[tool]",
        "[gears]\nstiffness = 3\nfrequency = 10\n[tool]",
        "gears: give stiffness or frequency, not both",
    ),
    "rigid": ("[tool]", "[gears]\nrigid = 1\n[tool]", "gears: rigid must be true or false, got 1"),
    "friction": (
        "[drives]",
        "[drives]\nstatic_friction = 1\ncoulomb_friction = 2",
        "drives: static_friction must be >= coulomb_friction, got 1 and 2 N m on axis 1",
    ),
    "hinge": ("[tool]", '[[structure]]\nname = "a"\n[tool]', "structure 1 lacks link, direction,"),
    "link of a hinge": (
        "[tool]",
        '[[structure]]\nname = "a"\nlink = 5\ndirection = [1, 0, 0]\nstiffness = 1e5\n[tool]',
        r"structure 1: link must be 0 \(base\) to 4, got 5",
    ),
    "direction": (
        "[tool]",
        '[[structure]]\nname = "a"\nlink = 1\ndirection = [0, 0, 0]\nstiffness = 1e5\n[tool]',
        "structure 1: direction must not be zero",
    ),
    "lost motion": (
        "[tool]",
        "[gears]\nrigid = true\n[effects]\nlost_motion = 1e-5\n[tool]",
        "effects: lost_motion needs gears with springs",
    ),
    "ripple": ("[tool]", "[effects]\ntorque_ripple = 1\n[tool]", "effects: torque_ripple must h"),
    "temperature": (
        "[tool]",
        "[effects]\ngear_temperature = 20\n[tool]",
        "effects: gear_temperature must be a finite number >= 26 and <= 80 deg C, got 20",
    ),
    "no lost motion": (
        "[tool]",
        "[effects]\nsoft_stiffness = 1e4\n[tool]",
        "effects: soft_stiffness needs lost_motion",
    ),
    "speed": ("speed = [7,", "speed = [0,", "limits: speed must be > 0, got 0 on axis 1"),
    "coupling": ('name = "SCARA"', "coupling = 3", "coupling must be a list of rows, got 3"),
    "both": ('name = "SCARA"', 'name = "SCARA"\nmodel = "a.xml"', "model has the hardware: leave"),
    "left-handed": (
        "quaternion = [0, 1, 0, 0]",
        "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]",
        "pose p3: rotation must be right-handed, got a reflection",
    ),
    "skewed": (
        "quaternion = [0, 1, 0, 0]",
        "rotation = [[1, 0, 0], [0, 1, 0], [0, 0.1, 1]]",
        "pose p3: rotation must have columns of length 1 at right angles",
    ),
    "shape of a rotation": (
        "quaternion = [0, 1, 0, 0]",
        "rotation = [[1, 0], [0, 1]]",
        "pose p3: rotation must be 3 rows of 3 numbers",
    ),
    "no pose": (r"[pose.p1]", "[other.p1]", "the file has the unknown key 'other'"),
    "no links": ("[[link]]", "[[links]]", "the file has the unknown key 'links'; keys: name,"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_hardware_is_refused_in_one_line(tmp_path, wrong):
    old, new, said = WRONG[wrong]
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
