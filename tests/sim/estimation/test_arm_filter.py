"""Noise and sensor models of the arm's filter, each by its stationary statistics."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from armside import assets
from armside.sim.estimation.arm_filter import arm_filter
from armside.sim.estimation.linearised_arm import imu_kinematics, linearised
from armside.sim.estimation.nominal import nominal_arm
from armside.sim.instruments.imu import ImuCfg
from armside.sim.robot.model import load_model

PHI = np.deg2rad([3.5, 7.8, 12.4, 18.2, -9.2, -11.6])
CFG = ImuCfg()


@pytest.fixture(scope="module")
def model():
    arm = linearised(nominal_arm(load_model(assets.LARGE_ROBOT_XML)), PHI)
    return arm_filter(arm, CFG)


def low_pass(model, k):
    """States of a triad's low-pass: readings and their rates."""
    start = 2 * model.n_free + 6 * k
    return np.arange(start, start + 3), np.arange(start + 3, start + 6)


@pytest.mark.parametrize("k", [0, 1])
def test_each_triad_has_the_low_pass_and_the_noise_of_its_data_sheet(model, k):
    """Poles of a second-order Butterworth; variance of the reading is density^2 pi B / sqrt(8)."""
    triad = (CFG.accelerometer, CFG.gyroscope)[k]
    own = np.concatenate(low_pass(model, k))
    A, W = model.A[np.ix_(own, own)], model.intensity[np.ix_(own, own)]
    omega = 2 * np.pi * triad.bandwidth
    poles = np.linalg.eigvals(A)
    assert np.abs(poles) == pytest.approx(np.full(6, omega))
    assert poles.real == pytest.approx(np.full(6, -omega / np.sqrt(2)))
    P = solve_continuous_lyapunov(A, -W)
    # one-sided density through a Butterworth of second order: its noise bandwidth is 1.11 B
    expected = triad.noise_density**2 * np.pi * triad.bandwidth / np.sqrt(8)
    assert np.diag(P)[:3] == pytest.approx(np.full(3, expected))
    gain = -np.linalg.solve(A, np.vstack([np.zeros((3, 3)), omega**2 * np.eye(3)]))
    assert gain[:3] == pytest.approx(np.eye(3))  # slow signals pass unchanged


def test_the_unexplained_torque_has_its_size_and_corner(model):
    own = 2 * model.n_free + 12 + np.arange(6)
    A, W = model.A[np.ix_(own, own)], model.intensity[np.ix_(own, own)]
    assert np.linalg.eigvals(A) == pytest.approx(np.full(6, -2 * np.pi * 20.0))
    std = np.sqrt(np.diag(solve_continuous_lyapunov(A, -W)))
    assert std == pytest.approx(0.05 * 6e-5 * model.arm.stiffness)
    assert std == pytest.approx(model.torque)


def test_readings_are_low_passed_motion_and_bias(model):
    m = 2 * model.n_free + 12
    bias = np.arange(m + 6, m + 12)
    assert model.C[:, bias] == pytest.approx(np.eye(6))
    readings = np.concatenate([low_pass(model, k)[0] for k in (0, 1)])
    assert model.C[:, readings] == pytest.approx(np.eye(6))
    assert np.count_nonzero(model.C) == 12
    walk = np.diag(model.intensity)[bias]
    assert np.sqrt(walk) == pytest.approx([1e-3] * 3 + [1e-4] * 3)


def test_an_accelerometer_sees_motion_and_tilt_and_a_gyro_sees_the_rate(model):
    """Inputs of the low-passes: J q'' + (gravity turned) q, and J q'."""
    n, arm = model.n_free, model.arm
    rng = np.random.default_rng(0)
    q, q_dot = rng.standard_normal((2, n))
    state = np.zeros(len(model.A))
    state[:n], state[n : 2 * n] = q, q_dot
    rate = model.A @ state
    q_ddot = rate[n : 2 * n]
    for k, expected in (
        (0, arm.imu_jacobian[:3] @ q_ddot + arm.imu_gravity @ q),
        (1, arm.imu_jacobian[3:] @ q_dot),
    ):
        omega = 2 * np.pi * (CFG.accelerometer, CFG.gyroscope)[k].bandwidth
        assert rate[low_pass(model, k)[1]] == pytest.approx(omega**2 * expected)
    # a tilt of the IMU by theta moves theta x g into its axes
    tilt = arm.imu_jacobian[3:]
    *_, up = imu_kinematics(nominal_arm(load_model(assets.LARGE_ROBOT_XML)).motion, arm.q[None])
    expected = np.cross(up, tilt.T).T
    assert arm.imu_gravity == pytest.approx(expected, rel=1e-3, abs=1e-3)
