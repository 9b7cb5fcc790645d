"""Masses of a URDF file as bodies of the robot."""

import mujoco
import numpy as np
import pytest

from armside.kinematics import read_urdf
from armside.kinematics.equations.inertial_model import InertialModel
from armside.kinematics.rigid import link_transform


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
