"""The two robots against what is known about them."""

import numpy as np
import pytest

from armside.kinematics import (
    IRB1400,
    IRB1400_IMU,
    compile,
)

ZERO = np.zeros(6)
# The test pose of the thesis's reference values: motor angles, rates, accelerations.
PHI = np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])
PHI_DOT = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.7])
PHI_DDOT = np.array([1.0, -1.0, 0.5, 0.25, -0.75, 2.0])


def test_tool_of_the_irb1400_moves_as_its_differentiated_transform():
    functions = compile(IRB1400)
    p = [0.833863586697, 0.0677164979361, 0.97871948893]
    v = [-0.291321676699, 0.401563271218, -0.294114480931]
    a = [-0.957225851488, 0.456305735527, -0.558421823664]
    omega = [0.470069073482, 0.309894915894, 0.710066580393]
    omega_dot = [2.05212296886, -0.0165409921025, 0.765931515102]
    np.testing.assert_allclose(functions.pose(PHI)[:3, 3], p, rtol=0, atol=1e-10)
    np.testing.assert_allclose(functions.jacobian(PHI) @ PHI_DOT, v + omega, rtol=0, atol=1e-10)
    acceleration = functions.acceleration(PHI, PHI_DOT, PHI_DDOT)
    np.testing.assert_allclose(acceleration, a + omega_dot, rtol=0, atol=1e-9)


def test_imu_of_the_irb1400_moves_as_its_differentiated_transform():
    functions = compile(IRB1400_IMU)
    p = [0.852717206049, -0.0237716931224, 1.01149832256]
    v = [-0.216200975837, 0.399542280286, -0.34296289092]
    a = [-0.90139719291, 0.479782945381, -0.770084512957]
    np.testing.assert_allclose(functions.pose(PHI)[:3, 3], p, rtol=0, atol=1e-10)
    np.testing.assert_allclose((functions.jacobian(PHI) @ PHI_DOT)[:3], v, rtol=0, atol=1e-10)
    acceleration = functions.acceleration(PHI, PHI_DOT, PHI_DDOT)
    np.testing.assert_allclose(acceleration[:3], a, rtol=0, atol=1e-9)


def test_determinant_of_the_irb1400_jacobian_in_joint_variables():
    J_theta = compile(IRB1400).jacobian(PHI) @ np.linalg.inv(IRB1400.coupling)
    assert np.linalg.det(J_theta) == pytest.approx(0.149543809817, abs=1e-10)


def test_zero_pose_jacobian_has_rank_five_and_the_coupled_second_column():
    J = compile(IRB1400).jacobian(ZERO)
    assert np.linalg.matrix_rank(J, tol=1e-9) == 5
    np.testing.assert_allclose(J[:, 1], [0.6, 0, 0, 0, 0, 0], rtol=0, atol=1e-12)
