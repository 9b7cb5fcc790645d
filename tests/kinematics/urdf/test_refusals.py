"""Bad URDF files: one line with the file, the element and what is allowed."""

import re

import pytest

from armside.kinematics import read_urdf

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
        ('velocity="2"', 'velocity="0"', "joint 'j1': limit velocity must be > 0"),
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


def test_a_tree_without_a_tip_names_its_ends(tmp_path):
    joint = '<joint name="j3" type="fixed"><parent link="one"/><child link="eye"/></joint>'
    text = ARM.replace("</robot>", f'<link name="eye"/>{joint}</robot>')
    assert "choose a tip link, as in FILE.urdf#TIP: eye, two" in refused(tmp_path, text)
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
