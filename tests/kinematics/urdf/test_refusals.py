"""Bad URDF files: one line with the file, the element and what is allowed."""

import re

import numpy as np
import pytest

from armside.kinematics import Body, read_urdf
from armside.kinematics.equations.inertial_model import nearest_inertia
from armside.kinematics.urdf.reader import SPEED

ARM = """<robot name="arm"><link name="base"/>
<link name="one"><inertial><mass value="2"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="two"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" velocity="2"/></joint>
<joint name="j2" type="revolute"><parent link="one"/><child link="two"/>
  <limit lower="-1" upper="1" velocity="2"/></joint></robot>"""


def refused(tmp_path, text, **ends) -> str:
    file = tmp_path / "bad.urdf"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ValueError, match=r"^bad\.urdf: ") as caught:
        read_urdf(file, **ends)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("</robot>", "", "damaged XML: no element found"),
        ("<robot", "<!DOCTYPE robot [<!ENTITY a 'b'>]><robot", "no document type and no entities"),
        ('<parent link="one"/>', '<parent link="on"/>', "parent link 'on' is not in the file"),
        ('<child link="two"/>', '<child link="base"/>', "is in a loop"),
        ('<child link="two"/>', '<child link="one"/>', "closes a loop: 'j1' and 'j2'"),
        ('<mass value="2"/>', '<mass value="0"/>', "link 'one': mass must be > 0 kg, got 0"),
        ('<mass value="2"/>', '<mass value="nan"/>', "mass must be a number up to 1e+06"),
        ('ixx="0.1"', 'ixx="0.9"', "link 'one': inertia .* triangle inequality"),
        ('lower="-1" upper="1"', 'lower="1" upper="-1"', "limit lower must be below upper"),
        ('velocity="2"', 'velocity="-1"', "joint 'j1': limit velocity must be >= 0"),
        ('ixx="0.1"', 'ixx="0.2001"', r"the nearest: \[0\.2000.*, 0\.1000.*, 0\.1000"),
        ('type="revolute"', 'type="rotary"', "type must be one of revolute, continuous"),
        ('type="revolute"', 'type="floating"', "joint 'j1' is floating; a chain may have"),
        ('type="revolute"', 'type="planar"', "joint 'j1' is planar; a chain may have"),
        ('<axis xyz="0 0 1"/>', '<mimic joint="j2"/>', "joint 'j1' mimics 'j2'"),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', "axis must not be zero"),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 1"/>', "axis xyz must be three numbers"),
        ('<axis xyz="0 0 1"/>', '<origin rpy="a 0 0"/>', "origin rpy must be a number"),
        ('name="j2"', 'name="j1"', "joint 'j1' is there twice"),
        ('<link name="two"/>', '<link name="two"/><link name="x"/>', "one link without a parent"),
    ],
)
def test_each_fault_is_one_line(old, new, complaint, tmp_path):
    assert old in ARM
    message = refused(tmp_path, ARM.replace(old, new, 1))
    assert re.search(complaint.replace("+", r"\+"), message), message


@pytest.mark.parametrize(("fixed_to", "name"), [("one", "tool0"), ("base", "eye")])
def test_the_tip_is_the_frame_of_the_tool_or_the_only_end_that_moves(fixed_to, name, tmp_path):
    joint = (
        f'<joint name="f" type="fixed"><parent link="{fixed_to}"/><child link="{name}"/></joint>'
    )
    text = ARM.replace("</robot>", f'<link name="{name}"/>{joint}</robot>')
    (file := tmp_path / "arm.urdf").write_text(text)
    assert read_urdf(file).joints == (("j1",) if name == "tool0" else ("j1", "j2"))


@pytest.mark.parametrize("stated", ['velocity="0"', ""])
def test_a_joint_without_a_speed_is_named(stated, tmp_path):
    (file := tmp_path / "arm.urdf").write_text(ARM.replace('velocity="2"', stated, 1))
    arm = read_urdf(file)
    assert arm.without_speed == ("j1",)
    assert arm.limits.speed == (SPEED, 2.0)


@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_inertia_is_one_that_a_body_has_and_near_where_rounding_missed_it(seed):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(3, 3))
    six = np.array([half[i] @ half[j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))])
    Body(mass=1, inertia=(*nearest_inertia(six),))  # of any tensor, such as one of second moments
    flat = np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]) * (1.0 + 1e-4 * rng.uniform(0, 1, 6))
    np.testing.assert_allclose(nearest_inertia(flat), flat, atol=1e-3)


def test_a_tree_without_a_tip_names_its_ends(tmp_path):
    joint = '<joint name="j3" type="fixed"><parent link="one"/><child link="eye"/></joint>'
    text = ARM.replace("</robot>", f'<link name="eye"/>{joint}</robot>')
    message = refused(tmp_path, text)
    assert "choose a tip link, by `robot new --tip TIP`, elsewhere FILE#TIP: eye, two" in message
    assert "links: base, one, two, eye" in refused(tmp_path, text, tip="tow")
    assert "no joint moves" in refused(tmp_path, text, base="one", tip="eye")
    assert "no chain leads" in refused(tmp_path, text, base="two", tip="eye")


def test_what_is_no_urdf_is_refused(tmp_path):
    assert "outermost element must be <robot>" in refused(tmp_path, "<mujoco/>")
    macro = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro/></robot>'
    assert "expand it first" in refused(tmp_path, macro)
    assert "utf-8" in refused(tmp_path, b"\xff\xfe<robot/>")
    assert "needs at least one <link>" in refused(tmp_path, "<robot/>")
    assert "at most" in refused(tmp_path, "<!--" + 10_000_001 * " " + "-->")
    with pytest.raises(ValueError, match="is no regular file"):
        read_urdf(tmp_path)


def test_the_nearest_inertia_moves_each_moment_by_a_third_of_what_is_missing():
    """1, 1 and 3 lack 1: the nearest point of the plane a + b = c."""
    found = nearest_inertia((1.0, 1.0, 3.0, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(found, [4 / 3, 4 / 3, 8 / 3, 0, 0, 0], rtol=2e-3, atol=1e-12)
