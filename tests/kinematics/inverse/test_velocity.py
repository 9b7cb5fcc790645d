"""Inverse velocity and acceleration, and statics."""

import numpy as np
import pytest
from tests.benchmarks._arms import PANDA

from armside.kinematics import IRB1400, compile
from armside.kinematics.inverse.velocity import (
    InconsistentMotionError,
    inverse_acceleration,
    inverse_velocity,
    joint_torques,
)
from armside.kinematics.singularity import rank_loss

RNG = np.random.default_rng(0)
REGULAR = np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])


def test_regular_square_jacobian_is_inverted():
    J = compile(IRB1400).jacobian(REGULAR)
    X_dot = RNG.normal(size=6)
    found = inverse_velocity(J, X_dot)
    assert found.rank == 6
    np.testing.assert_allclose(found.value, np.linalg.solve(J, X_dot), rtol=1e-10)


def test_seven_axes_have_internal_motion_that_the_tool_does_not_feel():
    """(2.13): the null-space term moves the arm and not the tool; without it the norm is least."""
    J = compile(PANDA).jacobian(RNG.uniform(0.3, 1, 7))
    X_dot, b = RNG.normal(size=6), RNG.normal(size=7)
    least, other = inverse_velocity(J, X_dot), inverse_velocity(J, X_dot, b)
    np.testing.assert_allclose(J @ other.value, X_dot, rtol=0, atol=1e-12)
    assert np.linalg.norm(other.value - least.value) > 1e-2
    assert np.linalg.norm(least.value) < np.linalg.norm(other.value)
    pseudo = np.linalg.pinv(J)
    expected = pseudo @ X_dot + (np.eye(7) - pseudo @ J) @ b
    np.testing.assert_allclose(other.value, expected, rtol=0, atol=1e-12)


def test_motion_in_a_lost_direction_fails_the_rank_test():
    """The zero pose aligns axes 4 and 6: rank 5, thesis (2.12)."""
    J = compile(IRB1400).jacobian(np.zeros(6))
    (lost,) = rank_loss(IRB1400, np.zeros(6)).lost.T
    with pytest.raises(InconsistentMotionError, match="rank 5 and cannot make"):
        inverse_velocity(J, lost)
    possible = J @ RNG.normal(size=6)
    assert inverse_velocity(J, possible).rank == 5


def test_inverse_acceleration_undoes_acceleration():
    functions = compile(IRB1400)
    rate, rate_dot = RNG.uniform(-1, 1, (2, 6))
    X_ddot = functions.acceleration(REGULAR, rate, rate_dot)
    found = inverse_acceleration(functions, REGULAR, rate, X_ddot)
    np.testing.assert_allclose(found.value, rate_dot, rtol=0, atol=1e-10)
    with pytest.raises(InconsistentMotionError):
        inverse_acceleration(functions, np.zeros(6), np.zeros(6), np.arange(6.0))


@pytest.mark.parametrize("bad", [np.full((6, 6), np.nan), np.eye(5), np.zeros(6)])
def test_bad_jacobians_are_refused(bad):
    with pytest.raises(ValueError, match=r"finite|must be \(m, n\)"):
        inverse_velocity(bad, np.zeros(6))
    with pytest.raises(ValueError, match="b must have shape"):
        inverse_velocity(np.eye(6), np.zeros(6), np.zeros(5))


def test_torques_do_the_work_of_the_wrench_through_the_coupling():
    functions = compile(IRB1400)
    rate, wrench = RNG.normal(size=6), RNG.normal(size=6)
    J = functions.jacobian(REGULAR)
    tau = joint_torques(J, wrench)
    assert tau @ rate == pytest.approx(wrench @ (J @ rate))
    J_theta = J @ np.linalg.inv(IRB1400.coupling)
    np.testing.assert_allclose(tau, IRB1400.coupling.T @ J_theta.T @ wrench, rtol=1e-12)
