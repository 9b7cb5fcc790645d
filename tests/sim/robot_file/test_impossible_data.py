"""Robot files whose numbers are in other units, contradict each other or leave out what follows."""

import codecs
import re

import numpy as np
import pytest

from armside import assets
from armside.kinematics import compile, read_robot, robot_toml
from armside.kinematics.codegen.robot_xml import urdf
from armside.scripts.cli import main
from armside.sim.motion.program_file import read_program
from armside.sim.part.contour_file import read_contour
from armside.sim.recordings.logs.controller_log import read_columns
from armside.sim.robot.individual_file import read_individual
from armside.sim.robot_file.find import load_robot, read_cell

FOLDER = assets.LARGE_ROBOT_XML.parent
SCARA, LARGE = FOLDER / "scara.toml", FOLDER / "large_robot.toml"

OTHER_UNITS = [
    (
        *(r'alpha = "pi"', "alpha = 90"),
        "link 2: alpha must be at most 6.283 rad, got 90; looks like degrees: 1.571 rad",
    ),
    (
        *(r"lower = \[-2.2", "lower = [-160"),
        "limits: lower of axis 1 must be at most 18.85 rad, got -160; looks like degrees: -2.793",
    ),
    (
        *(r"upper = \[2.2, 2.5, 0.2", "upper = [2.2, 2.5, 200"),
        "limits: upper of axis 3 must be at most 20 m, got 200; looks like millimetres: 0.2 m",
    ),
    ("a = 0.325", "a = 325", "link 1: a must be at most 20 m, got 325; lo"),
    (
        *(r"\A", "offset = [0, -90, 0, 0]\n"),
        "offset of axis 2 must be at most 6.283 rad, got -90; looks like degrees: -1.571 rad",
    ),
    (
        *(r"\[drives\]\n", "[drives]\nrotor_inertia = 2000\n"),
        "drives: rotor_inertia must be at most 1 kg m^2, got 2000; looks like g cm^2: 0.0002",
    ),
]


def changed(folder, old, new, source=SCARA):
    text = source.read_text(encoding="utf-8")
    assert re.search(old, text), old
    file = folder / "robot.toml"
    file.write_text(re.sub(old, new, text, count=1), encoding="utf-8")
    return file


@pytest.mark.parametrize(("old", "new", "said"), OTHER_UNITS)
def test_a_number_in_another_unit_is_refused_with_what_it_would_be(old, new, said, tmp_path):
    with pytest.raises(ValueError, match=f"^robot.toml: {re.escape(said)}"):
        read_cell(changed(tmp_path, old, new))


def test_urdf_limits_in_degrees_are_refused_with_the_joint(tmp_path):
    robot, limits = load_robot(str(SCARA)).arm
    text = urdf(robot, limits).replace(f'upper="{limits.upper[0]}"', 'upper="180"')
    assert 'upper="180"' in text
    (tmp_path / "arm.urdf").write_text(text, encoding="utf-8")
    said = r"arm\.urdf: joint '.*': limit upper must be .* got 180; looks like degrees: 3\.142 rad"
    with pytest.raises(ValueError, match=said):
        load_robot(str(tmp_path / "arm.urdf"))


@pytest.mark.parametrize("stated", [30.0, 36.4, 36.6])
def test_a_robot_weighs_at_least_what_its_bodies_do(stated, tmp_path):
    bodies = "".join(f"[[body]]\nmass = {m}\n" for m in (20, 10, 4, 2.5))
    file = changed(tmp_path, "mass = 20.*\n", f"mass = {stated}\n{bodies}")
    if stated > 36.5:
        assert read_cell(file).robot.n_joints == 4
        return
    said = f"hardware: mass must exceed that of base and links, got {stated:g} kg and 36.5 kg"
    with pytest.raises(ValueError, match=said):
        read_cell(file)


@pytest.mark.parametrize("home", ["home = [0.3, 0.4, 0.1, 0]\n", ""])
def test_without_a_pose_the_first_is_the_tool_at_home(home, tmp_path):
    text = SCARA.read_text(encoding="utf-8").split("[pose.")[0]
    file = tmp_path / "robot.toml"
    file.write_text(re.sub(r"(?m)^home = .*\n", home, text), encoding="utf-8")
    cell = read_cell(file)
    assert cell.home is not None
    T = compile(cell.robot).pose(np.array(cell.home))
    np.testing.assert_allclose(cell.poses["p1"].position, T[:3, 3], atol=1e-12)
    assert "pose p1: position" in [taken.field for taken in cell.estimates]


@pytest.mark.parametrize("file", [SCARA, LARGE, FOLDER / "two_link.toml"])
def test_one_function_reads_the_robot_of_any_file(file):
    arm, cell = read_robot(file), read_cell(file)
    assert arm.robot == cell.robot
    assert arm.limits == cell.limits
    assert load_robot(str(file)).arm == arm


def test_limits_beside_a_urdf_stand_in_place_of_its_own(tmp_path):
    arm = load_robot(str(SCARA)).arm
    (tmp_path / "arm.urdf").write_text(urdf(*arm), encoding="utf-8")
    (tmp_path / "robot.toml").write_text('urdf = "arm.urdf"\nlimits.speed = [1, 2, 3, 4]\n')
    file = tmp_path / "robot.toml"
    for limits in (read_robot(file).limits, read_cell(file).limits):
        assert limits.speed == (1.0, 2.0, 3.0, 4.0)
        assert limits.lower == pytest.approx(arm.limits.lower)


def test_what_is_taken_for_a_speed_that_a_urdf_lacks_is_said(tmp_path, capsys):
    text = urdf(*load_robot(str(SCARA)).arm)
    none = re.sub(r'velocity="[^"]*"', 'velocity="0"', text, count=1)
    assert none != text
    (tmp_path / "arm.urdf").write_text(none, encoding="utf-8")
    (tmp_path / "robot.toml").write_text('urdf = "arm.urdf"\n')
    estimates = {one.field: one.rule for one in read_cell(tmp_path / "robot.toml").estimates}
    assert estimates["limits: speed"].endswith("the URDF has no speed of joint_1")
    assert main(["robot", "new", str(tmp_path / "arm.urdf"), "--out", str(tmp_path / "new")]) == 0
    said = "speed of joint_1 is assumed: the file has 0 or none"
    assert f"Note: {said}" in capsys.readouterr().out
    assert said in (tmp_path / "new" / "robot.toml").read_text(encoding="utf-8")


def test_an_inertia_that_rounding_spoiled_is_refused_with_the_nearest(tmp_path):
    spoiled = r"inertia = \[0.001, 0.001, 0.001\]"
    with pytest.raises(ValueError, match=r"tool: inertia must .*; the nearest: ") as refused:
        read_cell(changed(tmp_path, spoiled, "inertia = [0.001, 0.001, 0.0020001]"))
    nearest = str(refused.value).split("the nearest: ")[1]
    assert read_cell(changed(tmp_path, spoiled, f"inertia = {nearest}")).robot.n_joints == 4


MARKED = [
    (read_robot, robot_toml(*load_robot(str(SCARA)).arm)),
    (read_cell, SCARA.read_text(encoding="utf-8")),
    (read_contour, "points = [[0, 0], [9, 0], [0, 9]]\n"),
    (read_individual, "\n"),
    (read_program, next((FOLDER / "programs").glob("*.toml")).read_text("utf-8")),
    (read_columns, 'time = "t"\ntime_unit = "s"\nmotor_angle = "q{}"\nangle_unit = "rad"'),
]


@pytest.mark.parametrize(("read", "text"), MARKED)
def test_a_byte_order_mark_is_no_part_of_a_file(read, text, tmp_path):
    (file := tmp_path / "file.toml").write_bytes(codecs.BOM_UTF8 + text.encode())
    read(file)
