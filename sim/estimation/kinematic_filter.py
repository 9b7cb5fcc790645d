"""The negative control: motor angles and IMU joined without a model of the arm's dynamics.

    x = (f, f', f'', accelerometer low-pass (6), gyro low-pass (6), b_a (3), b_g (3))

f is the twist of each axis, driven by white jerk and held near zero by a pseudo-measurement; the
IMU reads rigid kinematics of motor angle plus twist. No mass, no stiffness: at the frequencies of a
cut the accelerometer alone cannot tell a micrometre.
"""

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.kalman import Smoother
from armside.ilc.estimation.process import Process, first_order_hold, sampled_noise, simulate

from .arm_estimator import ArmEstimator
from .arm_identification import REST, Run

JERK = 60.0
"""Intensity's root of the twist's third derivative [rad/s^3/sqrt(Hz)] times 1e-3: a twist of 60
microradians at 7 Hz, the motion the arm shows. ESTIMATE."""
TWIST = 1e-4  # Standard deviation of the pseudo-measurement f = 0 [rad]


def kinematic_deviation(known: ArmEstimator, run: Run) -> Array:
    """(K, 6): displacement and rotation of the tool by twist, at the IMU's instants.

    Add it to the tool path of rigid kinematics. Of `known` only directions, IMU and clock are used.
    """
    arm, imu = known.model.arm, known.imu
    J, tilt, none = arm.imu_jacobian, arm.imu_gravity, np.zeros((3, 6))
    low, B_low, B_nonlinear = np.zeros((12, 12)), np.zeros((12, 18)), np.zeros((12, 6))
    W = np.zeros((36, 36))
    W[range(12, 18), range(12, 18)] = (1e-3 * JERK) ** 2
    for k, triad in enumerate((imu.accelerometer, imu.gyroscope)):
        x, rate = np.arange(6 * k, 6 * k + 3), np.arange(6 * k + 3, 6 * k + 6)
        omega = 2.0 * np.pi * triad.bandwidth
        low[x, rate] = 1.0
        low[rate, x], low[rate, rate] = -(omega**2), -np.sqrt(2.0) * omega
        W[18 + rate, 18 + rate] = omega**4 * triad.noise_density**2 / 2.0
        B_nonlinear[rate, 3 * k + np.arange(3)] = omega**2
        ideal = (tilt, none, J[:3]) if k == 0 else (none, J[3:], none)
        B_low[rate] = omega**2 * np.hstack(ideal)
    phi_ddot = np.gradient(run.phi_dot, run.period, axis=0)
    driven = simulate(
        *first_order_hold(low, np.hstack((B_low, B_nonlinear)), run.period),
        np.hstack((run.phi, run.phi_dot, phi_ddot, run.nonlinear.reading)),
    )
    at = run.imu_time + known.clock_offset
    rigid = np.stack([np.interp(at, run.time, c) for c in driven[:, [0, 1, 2, 6, 7, 8]].T], axis=1)
    left = run.reading - rigid

    # One matrix: twist chain, the same low-passes driven by it, biases.
    A = np.zeros((36, 36))
    A[:6, 6:12] = A[6:12, 12:18] = np.eye(6)
    A[18:30, 18:30], A[18:30, :18] = low, B_low
    C = np.zeros((12, 36))
    C[range(6), [18, 19, 20, 24, 25, 26]] = 1.0
    C[range(6), range(30, 36)] = 1.0
    C[range(6, 12), range(6)] = 1.0
    walk = known.process_noise.bias_walk
    W[range(30, 36), range(30, 36)] = np.repeat([walk, 0.1 * walk], 3) ** 2
    step = 1.0 / imu.rate
    Ad, Q = sampled_noise(A, W, step)
    R = np.diag(np.r_[np.diag(known.model.reading_covariance), np.full(6, TWIST**2)])
    P = np.diag(np.r_[np.full(6, 1e-14), np.full(6, 1e-12), np.full(6, 1e-6), np.full(18, 1e-2)])
    start = np.zeros(36)
    start[30:] = np.nanmean(left[at < REST], axis=0)
    y = np.hstack((left, np.zeros((len(left), 6))))
    states = Smoother(Process(A=Ad, Q=Q, C=C, R=R), P, np.isfinite(y))(y, start)
    return states.smoothed[:, :6] @ arm.tool_jacobian.T
