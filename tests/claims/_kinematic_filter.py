"""The negative control: motor angles and IMU joined without a model of the arm's dynamics.

    x = (f, f', f'', accelerometer low-pass (6), gyro low-pass (6), b_a (3), b_g (3))

f is the twist of each axis, driven by white jerk and held near zero by a pseudo-measurement; the
IMU reads rigid kinematics of motor angle plus twist. No mass, no stiffness: at the frequencies of a
cut the accelerometer alone cannot tell a micrometre.
"""

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.kalman import Smoother
from armside.ilc.estimation.process import Process, sampled_noise
from armside.sim.estimation.arm_filter import BIAS_WALK
from armside.sim.estimation.deflection import Deflection, explained
from armside.sim.estimation.estimator import ToolEstimator
from armside.sim.estimation.imu_health import REST
from armside.sim.estimation.rigid_motion import RigidMotion
from armside.sim.instruments.imu import ImuSamples

JERK = 60.0
"""Intensity's root of the twist's third derivative [rad/s^3/sqrt(Hz)] times 1e-3: a twist of 60
microradians at 7 Hz, the motion the arm shows. ESTIMATE."""
TWIST = 1e-4  # Standard deviation of the pseudo-measurement f = 0 [rad]


def kinematic_deviation(known: ToolEstimator, motion: RigidMotion, samples: ImuSamples) -> Array:
    """(K, 6): displacement and rotation of the tool by twist, at the IMU's instants.

    Add it to the tool path of rigid kinematics. Of `known` only directions, IMU and clock are used.
    """
    arm, imu = known.models[0].arm, known.imu
    axes, a = arm.axes, len(arm.axes)
    still = np.zeros((len(motion.time), arm.n_free))
    rigid = explained(motion, Deflection(still, still, still), imu)
    at = samples.time + known.parameters.clock_offset
    reading = np.hstack((samples.acceleration, samples.angular_velocity))
    left = reading - rigid(np.clip(at, motion.time[0], motion.time[-1]))

    # One matrix: twist chain, low-passes driven by it, biases.
    J, tilt, none = arm.imu_jacobian[:, axes], arm.imu_gravity[:, axes], np.zeros((3, a))
    low, bias = 3 * a, 3 * a + 12
    size = bias + 6
    A, W = np.zeros((size, size)), np.zeros((size, size))
    A[: 2 * a, a:low] = np.eye(2 * a)
    W[range(2 * a, low), range(2 * a, low)] = (1e-3 * JERK) ** 2
    for k, triad in enumerate((imu.accelerometer, imu.gyroscope)):
        x, rate = low + np.arange(6 * k, 6 * k + 3), low + np.arange(6 * k + 3, 6 * k + 6)
        omega = 2.0 * np.pi * triad.bandwidth
        A[x, rate] = 1.0
        A[rate, x], A[rate, rate] = -(omega**2), -np.sqrt(2.0) * omega
        A[rate, :low] = omega**2 * np.hstack((tilt, none, J[:3]) if k == 0 else (none, J[3:], none))
        W[rate, rate] = omega**4 * triad.noise_density**2 / 2.0
    C = np.zeros((6 + a, size))
    C[range(6), low + np.array([0, 1, 2, 6, 7, 8])] = 1.0
    C[range(6), range(bias, size)] = 1.0
    C[range(6, 6 + a), range(a)] = 1.0
    walk = np.repeat([BIAS_WALK, 0.1 * BIAS_WALK], 3)
    W[range(bias, size), range(bias, size)] = walk**2
    Ad, Q = sampled_noise(A, W, 1.0 / imu.rate)
    R = np.diag(np.r_[np.diag(known.models[0].reading_covariance), np.full(a, TWIST**2)])
    P = np.diag(np.repeat([1e-14, 1e-12, 1e-6, 1e-2], [a, a, a, 18]))
    start = np.zeros(size)
    start[bias:] = np.nanmean(left[at < REST], axis=0)
    y = np.hstack((left, np.zeros((len(left), a))))
    states = Smoother(Process(A=Ad, Q=Q, C=C, R=R), P, np.isfinite(y))(y, start)
    return states.smoothed[:, :a] @ arm.tool_jacobian[:, axes].T
