"""Nonlinear residual of a linearised arm: its matrices depend on the pose.

The filters' arm is linear around rest. Over a fast cut the Jacobian changes by a few thousandths,
and the second harmonic of a circle excites the structure's resonances: tens of micrometres. The
residual is small, so it is computed along an approximate motion and is an input of the linear arm:

    M0 dq'' + ... = S (K dphi + D dphi') - torque        y = J0 dq'' + ... + reading
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from armside.arrays import Array

from ..robot.linkage import FreeMotion
from .linearised_arm import LinearisedArm
from .nominal import NominalArm


@dataclass(frozen=True, kw_only=True, eq=False)
class NonlinearResidual:
    """Residual of the linear model along a motion."""

    torque: Array
    """(N, n) [N m], that the motion takes beyond the linear arm's."""
    reading: Array
    """(N, 6) [m/s^2], [rad/s], that an ideal IMU reads beyond the linear arm's."""


def nonlinear_residual(
    arm: NominalArm, linear: LinearisedArm, q: Array, q_dot: Array, q_ddot: Array
) -> NonlinearResidual:
    """Along a motion of the arm, (N, n) each: angles from rest and their derivatives.

    linear: the same arm at rest, before the motion.
    """
    torque, reading = inverse_dynamics(arm.motion, linear.q + q, q_dot, q_ddot)
    still = np.zeros((1, linear.n_free))
    rest_torque, rest_reading = inverse_dynamics(arm.motion, linear.q[None], still, still)
    J = linear.imu_jacobian
    return NonlinearResidual(
        torque=torque
        - rest_torque
        - (q_ddot @ linear.mass.T + q_dot * linear.structure_damping + q @ linear.gradient.T),
        reading=reading
        - rest_reading
        - np.hstack((q_ddot @ J[:3].T + q @ linear.imu_gravity.T, q_dot @ J[3:].T)),
    )


def inverse_dynamics(
    motion: FreeMotion, q: Array, q_dot: Array, q_ddot: Array
) -> tuple[Array, Array]:
    """Torques (N, n) that motions take, gear springs left out, and readings (N, 6) of the IMU."""
    mj, data = motion.mj, motion.data()
    sensors = [mj.sensor(name).adr[0] + np.arange(3) for name in ("imu_acc", "imu_gyro")]
    picked = np.concatenate(sensors)
    torque, reading = np.empty_like(q), np.empty((len(q), 6))
    for i in range(len(q)):
        motion.move(data, q[i], q_dot[i], q_ddot[i])
        mujoco.mj_inverse(mj, data)
        torque[i], reading[i] = motion.forces(data, data.qfrc_inverse), data.sensordata[picked]
    return torque, reading
