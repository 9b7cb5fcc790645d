"""What the rollout of a run tells: the truth, the motor log, and the limits that were hit."""

import numpy as np
from numba import njit

from .instruments.encoder import quantise
from .model import N_AXES, RobotModel
from .recording import Array, Truth

Limits = tuple[tuple[str, int, float], ...]
"""Each limit that a run touched, as (limit, axis 1..6, first time [s])."""


def truth(
    model: RobotModel, initial_state: Array, controls: Array, states: Array, sensors: Array
) -> tuple[Truth, Limits]:
    """The truth of one run. Sensor row i belongs to time i h, state row i to (i + 1) h.

    Args:
        initial_state: full physics state.
        controls: (M, nu), motor units, as they were run.
        states, sensors: (M, ...), as the rollout returns them.
    """
    nq, motor = model.mj.nq, model.motor

    def before_step(columns: np.ndarray) -> Array:
        """The state at the start of each step: the initial one, then all but the last."""
        values = np.empty((len(states), len(columns)))
        values[0] = initial_state[columns]
        values[1:] = states[:-1, columns]
        return values

    time: Array = np.arange(len(states), dtype=np.float64) * model.timestep
    qpos = before_step(1 + np.arange(nq))
    angle, velocity = before_step(1 + motor), before_step(1 + nq + motor)
    integral = before_step(1 + nq + model.mj.nv + model.integrator)
    torque = drive_torque(model, controls, angle, velocity, integral)
    flex = before_step(1 + model.flex) if len(model.flex) else np.zeros((len(time), N_AXES))
    if model.gear_error is not None:
        error = model.gear_error(angle)
        angle -= error
        flex += error
    limits = limits_hit(model, time, angle, velocity, torque)
    record = Truth(
        time=time,
        motor_angle=angle,
        flex_angle=flex,
        motor_torque=torque,
        tool_position=sensors[:, model.sensors["tool0_pos"]],
        tool_quaternion=sensors[:, model.sensors["tool0_quat"]],
        imu_acceleration=sensors[:, model.sensors["imu_acc"]],
        imu_angular_velocity=sensors[:, model.sensors["imu_gyro"]],
        qpos=qpos,
    )
    return record, limits


def measured_angle(model: RobotModel, motor_angle: Array, encoder_noise: Array | None) -> Array:
    """What the encoders report, (N, 6) [rad] arm side, of motor angles (N, 6).

    encoder_noise: (N, 6) [motor rad], None where there is none.
    """
    drives = model.drives
    if encoder_noise is not None:
        motor_angle = motor_angle + encoder_noise / drives.gear
    if drives.encoder_counts > 0.0:
        motor_angle = quantise(motor_angle, drives.encoder_counts, drives.gear)
    return motor_angle


def drive_torque(
    model: RobotModel, controls: Array, angle: Array, velocity: Array, integral: Array
) -> Array:
    """(M, 6) [motor N m] that the drives deliver: the servo's law, limited.

    Args:
        controls: (M, 18), motor units.
        angle, velocity: (M, 6) [rad], [rad/s], arm side, at the same instants.
        integral: (M, 6) [rad s], motor side, of the position error; (M, 0) without integral gain.
    """
    drives, torque = model.drives, np.empty_like(angle)
    setting = np.array([drives.gear, drives.kp, drives.kd, drives.ki, drives.torque_limit])
    _servo(np.ascontiguousarray(controls), angle, velocity, integral, setting, torque)
    return torque


@njit(cache=True, nogil=True)
def _servo(
    controls: Array, angle: Array, velocity: Array, integral: Array, setting: Array, torque: Array
) -> None:  # pragma: no cover - compiled
    gear, kp, kd, ki, limit = setting
    for i in range(angle.shape[0]):
        for j in range(angle.shape[1]):
            asked = (
                kp[j] * (controls[i, 3 * j] - gear[j] * angle[i, j])
                + kd[j] * (controls[i, 3 * j + 1] - gear[j] * velocity[i, j])
                + controls[i, 3 * j + 2]
            )
            if integral.shape[1] > 0:
                asked += ki[j] * integral[i, j]
            if asked > limit[j]:
                asked = limit[j]
            elif asked < -limit[j]:
                asked = -limit[j]
            torque[i, j] = asked


def limits_hit(
    model: RobotModel, time: Array, angle: Array, velocity: Array, torque: Array
) -> Limits:
    """Which limits a run touched.

    Args:
        time: (M,) [s].
        angle, velocity: (M, 6) [rad], [rad/s], arm side.
        torque: (M, 6) [motor N m].
    """
    drives = model.drives
    watched = (
        ("torque", torque, -drives.torque_limit, drives.torque_limit),
        ("speed", velocity, -drives.speed_limit, drives.speed_limit),
        ("joint", angle, model.joint_range[:, 0], model.joint_range[:, 1]),
    )
    hits: list[tuple[str, int, float]] = []
    for name, signal, low, high in watched:
        first = _first_beyond(signal, np.array([low, high]))
        touched = np.flatnonzero(first >= 0)
        hits += [(name, int(axis) + 1, float(time[first[axis]])) for axis in touched]
    return tuple(hits)


@njit(cache=True, nogil=True)
def _first_beyond(signal: Array, limits: Array) -> np.ndarray:  # pragma: no cover - compiled
    """(n,), the first row of each column of a signal (M, n) that is not between limits (2, n).

    -1 where there is none.
    """
    first = np.full(signal.shape[1], -1)
    for i in range(signal.shape[0]):
        for j in range(signal.shape[1]):
            if first[j] < 0 and (signal[i, j] <= limits[0, j] or signal[i, j] >= limits[1, j]):
                first[j] = i
    return first
