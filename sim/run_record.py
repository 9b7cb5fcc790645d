"""From one rollout to the recording of a run: the truth, the log, and the limits that were hit."""

from typing import TYPE_CHECKING

import numpy as np

from .instruments.encoder import quantise
from .model import N_AXES, RobotModel
from .recording import Array, Recording, Truth

if TYPE_CHECKING:
    from .job import Job


def arrange(
    job: "Job",
    correction: Array,
    controls: Array,
    encoder_noise: Array | None,
    states: Array,
    sensors: Array,
) -> Recording:
    """The recording of one run. Sensor row i belongs to time i h, state row i to (i + 1) h.

    Args:
        correction: (N, 6) [rad], u.
        controls: (M, nu), motor units, as they were run.
        encoder_noise: (M, 6) [motor rad], None where there is none.
        states, sensors: (M, ...), as the rollout returns them.
    """
    model, step = job.model, job.model.timestep
    nq, motor = model.mj.nq, model.motor
    qpos = _before_step(job.initial_state, states, 1 + np.arange(nq))
    velocity = _before_step(job.initial_state, states, 1 + nq + motor)
    time: Array = np.arange(len(states), dtype=np.float64) * step
    integral = _before_step(job.initial_state, states, 1 + nq + model.mj.nv + model.integrator)
    torque = drive_torque(model, controls, qpos[:, motor], velocity, integral)
    angle = qpos[:, motor]
    flex = qpos[:, model.flex] if len(model.flex) else np.zeros((len(time), N_AXES))
    if model.gear_error is not None:
        error = model.gear_error(angle)
        angle, flex = angle - error, flex + error
    truth = Truth(
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
    log = slice(None, None, job.ratio)
    angle = truth.motor_angle[log]
    if encoder_noise is not None:
        angle = angle + encoder_noise[log] / model.drives.gear
    if model.drives.encoder_counts > 0.0:
        angle = quantise(angle, model.drives.encoder_counts, model.drives.gear)
    return Recording(
        time=time[log],
        reference=job.reference,
        correction=correction,
        motor_angle=angle,
        motor_torque=torque[log],
        truth=truth,
        limits_hit=limits_hit(model, truth, velocity),
    )


def _before_step(initial: Array, states: Array, columns: np.ndarray) -> Array:
    """Columns of the state at the start of each step: the initial state, then all but the last."""
    values = np.empty((len(states), len(columns)))
    values[0] = initial[columns]
    values[1:] = states[:-1, columns]
    return values


def drive_torque(
    model: RobotModel, controls: Array, angle: Array, velocity: Array, integral: Array
) -> Array:
    """(M, 6) [motor N m] that the drives deliver: the servo's law, limited.

    Args:
        controls: (M, 18), motor units.
        angle, velocity: (M, 6) [rad], [rad/s], arm side, at the same instants.
        integral: (M, 6) [rad s], motor side, of the position error; (M, 0) without integral gain.
    """
    drives = model.drives
    position, speed, torque = np.moveaxis(controls.reshape(-1, N_AXES, 3), 2, 0)
    asked = (
        drives.kp * (position - drives.gear * angle)
        + drives.kd * (speed - drives.gear * velocity)
        + torque
    )
    if integral.shape[1]:
        asked += drives.ki * integral
    return np.clip(asked, -drives.torque_limit, drives.torque_limit)


def limits_hit(
    model: RobotModel, truth: Truth, velocity: Array
) -> tuple[tuple[str, int, float], ...]:
    """Each limit that a run touched, as (limit, axis 1..6, first time [s])."""
    drives, reach = model.drives, model.joint_range
    angle, torque = truth.motor_angle, truth.motor_torque
    watched = (
        ("torque", torque, -drives.torque_limit, drives.torque_limit),
        ("speed", velocity, -drives.speed_limit, drives.speed_limit),
        ("joint", angle, reach[:, 0], reach[:, 1]),
    )
    hits: list[tuple[str, int, float]] = []
    for name, signal, low, high in watched:
        touched = (signal.min(axis=0) <= low) | (signal.max(axis=0) >= high)
        for axis in np.flatnonzero(touched):
            beyond = (signal[:, axis] <= low[axis]) | (signal[:, axis] >= high[axis])
            hits.append((name, int(axis) + 1, float(truth.time[np.argmax(beyond)])))
    return tuple(hits)
