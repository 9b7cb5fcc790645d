"""Friction feedforward of the drives."""

import numpy as np
import pytest

from armside.kinematics.robot_file import GearTerm
from armside.sim.robot.drives import friction_torque, gear_error_of


@pytest.fixture
def drives(irb1400):
    return irb1400.drives


def test_the_feedforward_of_the_whole_friction_curve_is_scaled_by_its_gain(drives):
    v = np.array([[0.5] * 6])
    of_motor = v * drives.gear
    curve = (
        drives.coulomb_friction
        + (drives.static_friction - drives.coulomb_friction)
        * np.exp(-((of_motor / drives.stribeck_speed) ** 2))
        + drives.viscous_friction * of_motor
    )
    assert friction_torque(drives, v) == pytest.approx(0.7 * curve * drives.gear)


def test_friction_feedforward_is_odd_in_velocity_and_zero_at_rest(drives):
    v = np.array([[0.01, 0.03, 0.1, 0.3, 1.0, 3.0]])
    assert friction_torque(drives, -v) == pytest.approx(-friction_torque(drives, v))
    assert not friction_torque(drives, np.zeros((1, 6))).any()


TERMS = (
    GearTerm(1, 100.0, 2e-5, 0.3),
    GearTerm(3, 120.0, 1e-5, 2.0),
    GearTerm(1, 200.0, 5e-6, 1.0),
)


def test_error_of_a_joint_is_the_sum_of_its_terms():
    phi = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3))
    expected = np.zeros_like(phi)
    for term in TERMS:
        angle = term.order * phi[:, term.joint - 1] + term.phase
        expected[:, term.joint - 1] += term.amplitude * np.sin(angle)
    np.testing.assert_allclose(gear_error_of(TERMS, 3)(phi), expected, atol=1e-16)


def test_a_robot_without_that_joint_is_refused():
    with pytest.raises(ValueError, match="gear error of joint 3: the robot has 2 joints"):
        gear_error_of(TERMS, 2)


def test_the_rate_of_an_error_is_its_derivative_along_a_motion():
    phi, h = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 3)), 1e-6
    error, velocity = gear_error_of(TERMS, 3), np.array([0.3, -2.0, 1.5])
    quotient = (error(phi + h * velocity) - error(phi - h * velocity)) / (2.0 * h)
    rate = error.rate(phi, np.tile(velocity, (50, 1)))
    np.testing.assert_allclose(rate, quotient, atol=1e-9)  # of 5e-3: rounding over h is 1e-11
