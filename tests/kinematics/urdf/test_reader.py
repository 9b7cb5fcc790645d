"""URDF files read as robots: exported ones come back, others move as an independent reading."""

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armside.kinematics import (
    CATALOGUE,
    Joint,
    Robot,
    inverse_branches,
    read_urdf,
)
from armside.kinematics.codegen.robot_xml import urdf
from armside.kinematics.equations.inertial_model import InertialModel
from armside.kinematics.rigid import link_transform
from armside.kinematics.urdf import UrdfArm

ROUNDING = 1e-12


def pose(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Product of the link transforms of a standard robot without coupling."""
    T, values = np.eye(4), iter(q)
    for link in robot.links:
        T = T @ link_transform(link, next(values) if link.moves else 0.0)
    return T


def attribute(element: ElementTree.Element, tag: str, name: str, default: str = "") -> str:
    child = element.find(tag)
    return default if child is None else child.get(name, default)


def independent(text: str, tip: str, q: dict[str, float]) -> np.ndarray:
    """T_base_tip by homogeneous transforms of the XML itself, from the tip to the root."""
    elements = ElementTree.fromstring(text).iter("joint")
    joints = {attribute(joint, "child", "link"): joint for joint in elements}
    T = np.eye(4)
    while tip in joints:
        joint = joints[tip]
        xyz, rpy, axis = (
            np.array(attribute(joint, tag, name, default).split(), dtype=float)
            for tag, name, default in (
                ("origin", "xyz", "0 0 0"),
                ("origin", "rpy", "0 0 0"),
                ("axis", "xyz", "1 0 0"),
            )
        )
        place, motion = np.eye(4), np.eye(4)
        place[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
        place[:3, 3] = xyz
        along = q.get(joint.get("name", ""), 0.0) * axis / np.linalg.norm(axis)
        if joint.get("type") == "prismatic":
            motion[:3, 3] = along
        elif joint.get("type") != "fixed":
            motion[:3, :3] = Rotation.from_rotvec(along).as_matrix()
        T, tip = place @ motion @ T, attribute(joint, "parent", "link")
    return T


def read(tmp_path: Path, text: str, **ends) -> UrdfArm:
    file = tmp_path / "arm.urdf"
    file.write_text(text)
    return read_urdf(file, **ends)


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_exported_robot_comes_back_with_its_limits(name, tmp_path):
    robot, limits = CATALOGUE[name]
    arm = read(tmp_path, urdf(robot, limits))
    for phi in np.random.default_rng(0).uniform(-3, 3, (20, robot.n_joints)):
        q = robot.joint_variables(phi)
        expected = pose(robot, q)
        found = pose(arm.robot, robot.coupling @ phi)
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)
    uncoupled = [i for i, row in enumerate(robot.coupling) if np.count_nonzero(row) == 1]
    for i in uncoupled:
        assert arm.limits.lower[i] == limits.lower[i]
        assert arm.limits.upper[i] == limits.upper[i]
        assert arm.limits.speed[i] == limits.speed[i]


@pytest.mark.parametrize("name", ["ur10", "large"])
def test_an_exported_robot_keeps_its_closed_form(name, tmp_path):
    """The axes of the file still meet and are parallel: no constant link, no rounding, between."""
    robot = read(tmp_path, urdf(*CATALOGUE[name])).robot
    q = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    found = inverse_branches(robot, pose(robot, q), reference=q).phi
    assert np.nanmin(np.abs(found - q).max(axis=-1)) < 1e-9


def chain_text(rng: np.random.Generator, n: int, tilt: float = 1.0) -> tuple[str, str]:
    """A chain of n joints with axes and origins at random, and its tip link.

    tilt: size of the rotations from each axis to the next; small ones make them nearly parallel.
    """
    lines, axis = ['<robot name="drawn"><link name="l0"/>'], np.array([0.0, 0.0, 1.0])
    for i in range(1, n + 1):
        kind = rng.choice(["revolute", "continuous", "prismatic", "fixed"])
        xyz, rpy = rng.uniform(-0.5, 0.5, 3), tilt * rng.uniform(-3, 3, 3)
        axis = rng.normal(size=3) if tilt == 1.0 else axis
        words = [" ".join(map(repr, map(float, v))) for v in (xyz, rpy, axis)]
        lines += [
            f'<link name="l{i}"/><joint name="j{i}" type="{kind}"><parent link="l{i - 1}"/>',
            f'<child link="l{i}"/><origin xyz="{words[0]}" rpy="{words[1]}"/>',
            f'<axis xyz="{words[2]}"/>',
            '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>',
        ]
    lines.append(
        f'<link name="tip"/><joint name="end" type="revolute"><parent link="l{n}"/>'
        '<child link="tip"/><limit lower="-1" upper="1" velocity="1"/></joint></robot>'
    )
    return "\n".join(lines), "tip"


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 8), tilt=st.sampled_from([1, 1e-3, 1e-8, 0]))
def test_any_chain_moves_as_an_independent_reading(seed, n, tilt, tmp_path_factory):
    """Skewed, negative, parallel and nearly parallel axes, where common normals are far away."""
    rng = np.random.default_rng(seed)
    text, tip = chain_text(rng, n, float(tilt))
    arm = read(tmp_path_factory.mktemp("urdf"), text)
    for q in rng.uniform(-2, 2, (3, len(arm.joints))):
        expected = independent(text, tip, dict(zip(arm.joints, q, strict=True)))
        np.testing.assert_allclose(pose(arm.robot, q), expected, rtol=0, atol=1e-10)


HAND = """<robot name="hand written"><link name="world"/><link name="base"/><link name="a"/>
<link name="b"/><link name="tool"/><link name="camera"/>
<joint name="mount" type="fixed"><parent link="world"/><child link="base"/>
  <origin xyz="0 0 0.5" rpy="0.1 -0.2 0.3"/></joint>
<joint name="turn" type="continuous"><parent link="base"/><child link="a"/>
  <origin xyz="0.1 0 0.2" rpy="1.2 0 0"/><axis xyz="0 -2 0"/></joint>
<joint name="slide" type="prismatic"><parent link="a"/><child link="b"/>
  <origin rpy="0 0.7 0"/><axis xyz="-1 0 1"/>
  <limit lower="-0.1" upper="0.4" velocity="0.2"/></joint>
<joint name="flange" type="fixed"><parent link="b"/><child link="tool"/>
  <origin xyz="0 0.3 0" rpy="0 0 -1.5"/></joint>
<joint name="eye" type="fixed"><parent link="a"/><child link="camera"/></joint></robot>"""


def test_a_chain_is_chosen_by_its_base_and_tip(tmp_path):
    arm = read(tmp_path, HAND, tip="tool")
    assert arm.joints == ("turn", "slide")
    assert arm.limits.lower == (-2 * np.pi, -0.1)
    assert arm.limits.upper == (2 * np.pi, 0.4)
    assert arm.limits.speed == (np.pi, 0.2)
    assert [link.joint for link in arm.robot.links if link.moves] == [
        Joint.REVOLUTE,
        Joint.PRISMATIC,
    ]
    expected = independent(HAND, "tool", {"turn": 0.4, "slide": 0.2})
    np.testing.assert_allclose(pose(arm.robot, np.array([0.4, 0.2])), expected, atol=ROUNDING)
    inner = read(tmp_path, HAND, base="base", tip="b")
    from_base = np.linalg.inv(independent(HAND, "base", {})) @ independent(HAND, "b", {"turn": 1.0})
    np.testing.assert_allclose(pose(inner.robot, np.array([1.0, 0.0])), from_base, atol=ROUNDING)


def text(rng: np.random.Generator, n: int) -> str:
    """A chain with a body of random place and rotation on each link, and a fixed box beside it."""
    lines = ['<robot name="heavy"><link name="l0"/>']
    for i in range(1, n + 2):
        place = [" ".join(map(repr, map(float, rng.uniform(-1, 1, 3)))) for _ in range(5)]
        kind, parent = ("revolute", i - 1) if i <= n else ("fixed", 1)
        xx, yy, zz = map(float, rng.uniform(0.1, 0.15, 3))
        lines.append(
            f'<link name="l{i}"><inertial><origin xyz="{place[0]}" rpy="{place[1]}"/>'
            f'<mass value="{rng.uniform(1, 3)!r}"/>'
            f'<inertia ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" ixy="0.01" ixz="-0.02" iyz="0"/>'
            "</inertial></link>"
            f'<joint name="j{i}" type="{kind}"><parent link="l{parent}"/><child link="l{i}"/>'
            f'<origin xyz="{place[2]}" rpy="{place[3]}"/><axis xyz="{place[4]}"/>'
            '<limit lower="-3" upper="3" velocity="1" effort="1"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


def mass_matrix(model: InertialModel, q: np.ndarray) -> np.ndarray:
    """Sum of J^T M J of the bodies, by frames and axes written out here."""
    T, frames, axes, n = np.eye(4), [], [], model.robot.n_joints
    values = iter(q)
    for link in model.robot.links:
        if link.moves:
            axes.append((T[:3, 2], T[:3, 3], len(frames)))
        T = T @ link_transform(link, next(values) if link.moves else 0.0)
        frames.append(T)
    M = np.zeros((n, n))
    for number, (F, body) in enumerate(zip(frames, model.bodies, strict=True)):
        com = F[:3, 3] + F[:3, :3] @ np.array(body.com, dtype=float)
        J = np.zeros((6, n))
        for i, (z, p, first) in enumerate(axes):
            if first <= number:
                J[:, i] = [*np.cross(z, com - p), *z]
        xx, yy, zz, xy, xz, yz = map(float, body.inertia)
        tensor = F[:3, :3] @ [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] @ F[:3, :3].T
        M += float(body.mass) * J[:3].T @ J[:3] + J[3:].T @ tensor @ J[3:]
    return M


def test_the_mass_matrix_is_that_of_another_reader(tmp_path):
    """MuJoCo reads the same file; its bodies fixed to a link are merged as here."""
    xml = text(np.random.default_rng(2), 4)
    (tmp_path / "heavy.urdf").write_text(xml)
    arm = read_urdf(tmp_path / "heavy.urdf", tip="l4")
    theirs = mujoco.MjModel.from_xml_string(xml)
    data, q = mujoco.MjData(theirs), np.array([0.3, -0.8, 1.2, 0.5])
    data.qpos[:] = q
    mujoco.mj_forward(theirs, data)
    expected = np.zeros((4, 4))
    mujoco.mj_fullM(theirs, data, expected)
    found = mass_matrix(arm.inertial_model(), q)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_masses_that_no_serial_arm_has_are_no_bodies(tmp_path):
    xml = text(np.random.default_rng(2), 2).replace('type="fixed"', 'type="continuous"')
    (tmp_path / "gripper.urdf").write_text(xml)
    arm = read_urdf(tmp_path / "gripper.urdf", tip="l2")
    assert arm.bodies is None
    with pytest.raises(ValueError, match="has no masses, or some beside its chain that move"):
        arm.inertial_model()
