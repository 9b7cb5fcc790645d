"""The exported robot, read by another program."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
import sympy as sp

from armside.kinematics import (
    IRB1400,
    IRB1400_LIMITS,
    LARGE_ROBOT,
    UR10,
    UR10_LIMITS,
    Body,
    Convention,
    Link,
    Motor,
    Robot,
    compile,
)
from armside.kinematics.codegen import Language, write
from armside.kinematics.codegen.languages import interpreted
from armside.kinematics.codegen.robot_xml import mjcf, urdf
from armside.kinematics.equations import dynamics, forward_kinematics

READER = (
    '<mujoco><compiler boundmass="1" boundinertia="1" fusestatic="false" '
    'balanceinertia="true"/></mujoco>'
)


def loaded(robot: Robot, **options) -> mujoco.MjModel:
    """MuJoCo wants masses: it is told to make them up."""
    text = urdf(robot, **options)
    return mujoco.MjModel.from_xml_string(text.replace("</robot>", f"{READER}</robot>"))


def tool(model: mujoco.MjModel, q: np.ndarray) -> np.ndarray:
    data = mujoco.MjData(model)
    data.qpos = q
    mujoco.mj_kinematics(model, data)
    T = np.eye(4)
    T[:3, :3] = data.body("tool0").xmat.reshape(3, 3)
    T[:3, 3] = data.body("tool0").xpos
    return T


@pytest.mark.parametrize("convention", Convention)
def test_random_robots_keep_their_pose(convention, random_robot, interpreted):
    from armside.kinematics.equations import forward_kinematics

    rng = np.random.default_rng(3)
    for n in (1, 3, 6):
        robot = random_robot(rng, n, convention)
        phi = rng.uniform(-1, 1, n)
        expected = interpreted(forward_kinematics.pose(robot))(phi)
        actual = tool(loaded(robot), robot.coupling @ phi)
        np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12)


def test_irb1400_stands_in_its_zero_pose_with_all_joints_at_zero():
    model = loaded(IRB1400, limits=IRB1400_LIMITS)
    np.testing.assert_allclose(
        tool(model, np.zeros(6)), compile(IRB1400).pose(np.zeros(6)), rtol=0, atol=1e-12
    )
    assert [model.joint(i).name for i in range(6)] == [f"joint_{i}" for i in range(1, 7)]


def test_coupled_joint_is_stated_and_has_the_range_of_its_combination():
    text = urdf(IRB1400, IRB1400_LIMITS)
    assert "Coupling: joint_3 = -1 phi_2 +1 phi_3" in text
    model = loaded(IRB1400, limits=IRB1400_LIMITS)
    np.testing.assert_allclose(np.degrees(model.joint("joint_3").range), [-70, 70], atol=1e-9)
    assert "Coupling" not in urdf(LARGE_ROBOT)


def test_symbols_are_refused():
    with pytest.raises(ValueError, match="symbols: a"):
        urdf(Robot([Link(a="a")]))


def test_a_robots_name_is_no_xml():
    root = ElementTree.fromstring(urdf(Robot([Link(a=1)], name='A b"/><x>\x00&')))
    assert root.get("name") == "a_b____x___"


AT_45_DEG = Robot([Link(theta=np.pi / 4, a=1), Link(theta=np.pi / 3, a=1, alpha=np.pi / 4)])


@pytest.mark.parametrize("language", [each for each in Language if each is not Language.LATEX])
def test_no_macro_of_math_h_is_printed(language):
    for text in write(forward_kinematics.pose(AT_45_DEG), language).values():
        assert not re.search(r"\bM_\w", text)


def test_a_joint_at_45_degrees_has_its_pose():
    T = interpreted(forward_kinematics.pose(AT_45_DEG))([0.1, 0.2])
    first, second = np.pi / 4 + 0.1, np.pi / 4 + np.pi / 3 + 0.3
    expected = [np.cos(first) + np.cos(second), np.sin(first) + np.sin(second), 0.0]
    np.testing.assert_allclose(T[:3, 3], expected, rtol=0, atol=1e-15)


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
