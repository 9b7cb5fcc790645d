"""Measurement equations of encoders and an IMU, with a derived Jacobian."""

import numpy as np
import pytest

from armside.kinematics import IRB1400, IRB1400_IMU, Joint, Link, Robot, compile
from armside.kinematics.equations.imu_equations import measurement, measurement_jacobian

G = 9.82
GRAVITY = np.array([0, 0, -G])
RNG = np.random.default_rng(0)
PHI, PHI_DOT, PHI_DDOT = RNG.uniform(-1, 1, (3, 6))


def test_imu_at_rest_reads_gravity_and_nothing_else(interpreted):
    y = interpreted(measurement(IRB1400_IMU))(np.zeros(6), np.zeros(6), np.zeros(6))
    np.testing.assert_allclose(y, [*np.zeros(9), 0, 0, G], rtol=0, atol=1e-12)


def test_imu_reads_the_tool_motion_turned_into_its_axes(interpreted):
    """The recursion in moving axes against pose, Jacobian and acceleration in base axes."""
    y = interpreted(measurement(IRB1400_IMU))(PHI, PHI_DOT, PHI_DDOT)
    functions = compile(IRB1400_IMU)
    R = functions.pose(PHI)[:3, :3]
    omega = (functions.jacobian(PHI) @ PHI_DOT)[3:]
    a = functions.acceleration(PHI, PHI_DOT, PHI_DDOT)[:3]
    np.testing.assert_allclose(y[:6], PHI, rtol=0, atol=0)
    np.testing.assert_allclose(y[6:9], R.T @ omega, rtol=0, atol=1e-12)
    np.testing.assert_allclose(y[9:], R.T @ (a - GRAVITY), rtol=0, atol=1e-12)


@pytest.mark.parametrize("frame", range(1, 9))
def test_a_sensor_may_sit_on_any_link(frame, interpreted):
    """The same as a robot that ends there, its later motors irrelevant."""
    y = interpreted(measurement(IRB1400_IMU, frame=frame))(PHI, PHI_DOT, PHI_DDOT)
    n = min(frame, 6)
    shorter = Robot(
        IRB1400_IMU.links[:frame], IRB1400.coupling[:n, :n], IRB1400.offset[:n], name="part"
    )
    expected = interpreted(measurement(shorter))(PHI[:n], PHI_DOT[:n], PHI_DDOT[:n])
    np.testing.assert_allclose(y[6:], expected[n:], rtol=0, atol=1e-13)


def test_a_frame_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="frame must be 1 to 8, got 9"):
        measurement(IRB1400_IMU, frame=9)


def test_measurement_jacobian_is_the_finite_difference(interpreted, central):
    read = interpreted(measurement(IRB1400_IMU))
    H = interpreted(measurement_jacobian(IRB1400_IMU))(PHI, PHI_DOT, PHI_DDOT)
    x = np.concatenate([PHI, PHI_DOT, PHI_DDOT])
    expected = central(lambda x: read(x[:6], x[6:12], x[12:]), x)
    assert H.shape == (12, 18)
    np.testing.assert_allclose(H, expected, rtol=0, atol=1e-8)


def test_prismatic_joints_carry_sensors_too(interpreted):
    """A lift with an accelerometer reads gravity plus its own acceleration."""
    lift = Robot([Link(joint=Joint.PRISMATIC)])
    y = interpreted(measurement(lift))([0.3], [2.0], [1.5])
    np.testing.assert_allclose(y, [0.3, 0, 0, 0, 0, 0, G + 1.5], rtol=0, atol=1e-14)
