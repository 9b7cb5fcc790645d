"""Thesis 5.4.1: the pose of the IRB1400 by several toolboxes, on the motor angles of (5.13)."""

import mujoco
import numpy as np
import pytest
import sympy as sp
from tests.benchmarks._pinocchio import pinocchio_functions

from armside import kinematics
from armside.kinematics import IRB1400
from armside.kinematics.symbolic import procedures as dh
from armside.scripts.thesis import imu_checks
from armside.scripts.thesis.imu_checks import MUJOCO, differences, motor_angles
from armside.scripts.thesis.peers import toolbox_robot
from armside.sim.cell import CELLS
from armside.sim.robot.model import load_model

TOLERANCE = 1e-14
"""[m]; the thesis found differences in the magnitude of 1e-15."""
TENTHS = {motor: 4 if motor < 3 else 5 for motor in range(6)}
"""Motors 1 to 3 go to +-0.4 rad, motors 4 to 6 to +-0.5 rad, in steps of 0.1."""
GRID = [
    [sp.Rational(tenths, 10) if i == motor else sp.Integer(0) for i in range(6)]
    for motor, most in TENTHS.items()
    for tenths in range(-most, most + 1)
]


@pytest.fixture(scope="module")
def angles():
    return np.array(GRID, dtype=float)


@pytest.fixture(scope="module")
def exact():
    """Symbolic transforms with exact angles, evaluated to 30 digits."""
    transforms = [dh.matrix_t(dh.at(IRB1400, phi))[6].evalf(30) for phi in GRID]
    return np.array([np.array(T, dtype=float) for T in transforms])


def test_compiled_code_is_the_symbolic_transform(angles, exact):
    assert len(angles) == 3 * 9 + 3 * 11
    assert kinematics.compile(IRB1400).pose(angles) == pytest.approx(exact, abs=TOLERANCE)


def test_the_robotics_toolbox_that_the_thesis_used_agrees(angles, exact):
    pytest.importorskip("roboticstoolbox", reason="the Robotics Toolbox is an optional peer")
    peer = toolbox_robot(IRB1400)
    for phi, T in zip(angles, exact, strict=True):
        q = IRB1400.joint_variables(phi) - [float(link.theta) for link in IRB1400.links]
        found = peer.fkine(q).A
        assert found == pytest.approx(T, abs=TOLERANCE)


def test_pinocchio_agrees(angles, exact):
    pytest.importorskip("pinocchio", reason="pinocchio (pip install pin) is an optional peer")
    peer = pinocchio_functions(IRB1400)
    for phi, T in zip(angles, exact, strict=True):
        assert peer.pose(IRB1400.joint_variables(phi)) == pytest.approx(T, abs=TOLERANCE)


def test_mujoco_s_kinematics_of_the_closed_chain_agree(angles, exact):
    model = load_model(CELLS["irb1400"].xml)
    data = mujoco.MjData(model.mj)
    for phi, T in zip(angles, exact, strict=True):
        data.qpos[:] = model.posture @ phi
        mujoco.mj_kinematics(model.mj, data)
        tool = data.site("tool0")
        assert tool.xpos == pytest.approx(T[:3, 3], abs=TOLERANCE)
        assert tool.xmat.reshape(3, 3) == pytest.approx(T[:3, :3], abs=TOLERANCE)


def test_the_report_compares_the_toolboxes_on_the_angles_of_the_thesis(angles):
    assert motor_angles() == pytest.approx(angles, abs=1e-15)
    found = differences()
    largest = found[MUJOCO]
    assert largest is not None
    assert largest <= TOLERANCE
    assert imu_checks.toolbox_poses(found).holds
    assert not imu_checks.toolbox_poses({**found, "another": 2e-14}).holds
