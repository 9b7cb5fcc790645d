"""Masses of exported robots, read by MuJoCo from URDF and MJCF, beside the recursion over links."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import sympy as sp

from armside.kinematics import (
    UR10,
    UR10_LIMITS,
    Body,
    Convention,
    Link,
    Motor,
    Robot,
)
from armside.kinematics.codegen.robot_xml import mjcf, urdf
from armside.kinematics.equations import dynamics, forward_kinematics

ROUNDING = 1e-10
EXPORTS = {
    "urdf": lambda *a, **k: urdf(*a, **k).replace(
        "</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
    ),
    "mjcf": mjcf,
}


def mass_matrix(mj: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    D = np.zeros((mj.nv, mj.nv))
    mujoco.mj_forward(mj, data)
    mujoco.mj_fullM(mj, data, D)
    return D


@pytest.mark.parametrize("export", EXPORTS.values(), ids=EXPORTS)
@pytest.mark.parametrize("convention", Convention)
def test_mass_matrices_of_random_models_are_read_back(
    export, convention, random_robot, random_model, interpreted
):
    rng = np.random.default_rng(11)
    for n in (1, 4):
        robot = random_robot(rng, n, convention)
        model = random_model(rng, robot)
        model = replace(model, motors=(Motor(),) * n)
        phi = rng.uniform(-1, 1, n)
        ours = interpreted(dynamics.mass_matrix(model))(phi)
        mj = mujoco.MjModel.from_xml_string(export(robot, bodies=model.bodies))
        data = mujoco.MjData(mj)
        data.qpos[:] = robot.coupling @ phi
        found = robot.coupling.T @ mass_matrix(mj, data) @ robot.coupling
        np.testing.assert_allclose(found, ours, rtol=0, atol=ROUNDING)


def test_mjcf_has_the_pose_and_the_ranges_of_the_robot(interpreted):
    mj = mujoco.MjModel.from_xml_string(mjcf(UR10, UR10_LIMITS))
    data, phi = mujoco.MjData(mj), np.array([0.3, -1.2, 0.9, 0.4, 1.1, -0.6])
    data.qpos[:] = phi
    mujoco.mj_kinematics(mj, data)
    T = interpreted(forward_kinematics.pose(UR10))(phi)
    np.testing.assert_allclose(data.site("tool0").xpos, T[:3, 3], rtol=0, atol=1e-12)
    R = data.site("tool0").xmat.reshape(3, 3)
    np.testing.assert_allclose(R, T[:3, :3], rtol=0, atol=1e-12)
    np.testing.assert_allclose(mj.jnt_range, np.transpose([UR10_LIMITS.lower, UR10_LIMITS.upper]))


def test_links_without_mass_have_no_inertial_and_the_file_says_so():
    text = urdf(UR10)
    assert "<inertial>" not in text
    assert "No masses are known" in text
    bodies = [Body(mass=0)] * 5 + [Body(mass=2, inertia=(1, 1, 1, 0, 0, 0))]
    heavy = urdf(UR10, bodies=bodies)
    assert re.findall(r'<mass value="(.*)"/>', heavy) == ["2.0"]
    assert "<mass" in heavy.split('name="link_6"')[1]


def test_a_note_closes_no_comment():
    text = urdf(UR10, notes=["a --> b"])
    assert text.count("-->") == 1


def test_bodies_of_symbols_or_of_another_number_are_refused():
    one = Robot([Link(a=1)])
    with pytest.raises(ValueError, match="needs 1 bodies, got 2"):
        urdf(one, bodies=[Body(mass=1)] * 2)
    with pytest.raises(ValueError, match="needs bodies of numbers"):
        mjcf(one, bodies=[Body(mass=sp.Symbol("m"))])
