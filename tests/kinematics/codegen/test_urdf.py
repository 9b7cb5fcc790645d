"""The exported robot, read by another program."""

from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from armside.kinematics import (
    IRB1400,
    IRB1400_LIMITS,
    LARGE_ROBOT,
    Convention,
    Link,
    Robot,
    compile,
)
from armside.kinematics.codegen.robot_xml import urdf

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
