"""What the rollout of a run tells: the truth, the motor log, and the limits that were hit."""

import numpy as np
from numba import njit

from .gear_error import EXACT
from .instruments.encoder import quantise
from .model import N_AXES, RobotModel
from .recording import Array, Truth

Limits = tuple[tuple[str, int, float], ...]
"""Each limit that a run touched, as (limit, axis 1..6, first time [s])."""

WATCHED = ("torque", "speed", "joint")


def truth(
    model: RobotModel, initial_state: Array, controls: Array, states: Array, sensors: Array
) -> tuple[Truth, Limits]:
    """The truth of one run. Sensor row i belongs to time i h, state row i to (i + 1) h.

    Args:
        initial_state: full physics state.
        controls: (M, nu), motor units, as they were run.
        states, sensors: (M, ...), as the rollout returns them.
    """
    time: Array = np.arange(len(states), dtype=np.float64) * model.timestep
    qpos = np.empty((len(states), model.mj.nq))
    qpos[0] = initial_state[1 : 1 + model.mj.nq]
    qpos[1:] = states[:-1, 1 : 1 + model.mj.nq]
    angle, spring, torque = (np.empty((len(states), N_AXES)) for _ in range(3))
    first = _motors(
        np.ascontiguousarray(initial_state),
        np.ascontiguousarray(states),
        np.ascontiguousarray(controls),
        _columns(model),
        _servo(model),
        _limits(model),
        (angle, spring, torque),
    )
    record = Truth(
        time=time,
        gear_angle=angle,
        spring_angle=spring,
        motor_torque=torque,
        tool_position=sensors[:, model.sensors["tool0_pos"]],
        tool_quaternion=sensors[:, model.sensors["tool0_quat"]],
        imu_acceleration=sensors[:, model.sensors["imu_acc"]],
        imu_angular_velocity=sensors[:, model.sensors["imu_gyro"]],
        qpos=qpos,
        gear_error=model.gear_error or EXACT,
    )
    hits = tuple(
        (WATCHED[limit], int(axis) + 1, float(time[first[limit, axis]]))
        for limit, axis in np.argwhere(first >= 0)
    )
    return record, hits


def measured_angle(model: RobotModel, gear_angle: Array, encoder_noise: Array | None) -> Array:
    """What the encoders report, (N, 6) [rad] arm side, where the gears stand at (N, 6).

    encoder_noise: (N, 6) [motor rad], None where there is none.
    """
    drives, motor_angle = model.drives, gear_angle
    if model.gear_error is not None:
        motor_angle = motor_angle - model.gear_error(gear_angle)
    if encoder_noise is not None:
        motor_angle = motor_angle + encoder_noise / drives.gear
    if drives.encoder_counts > 0.0:
        motor_angle = quantise(motor_angle, drives.encoder_counts, drives.gear)
    return motor_angle


def _columns(model: RobotModel) -> np.ndarray:
    """(4, 6), where a state has each motor's angle and speed, its integral and its gear spring.

    -1 where a robot has no such thing.
    """
    nq, nv = model.mj.nq, model.mj.nv
    columns = np.full((4, N_AXES), -1)
    columns[0], columns[1] = 1 + model.motor, 1 + nq + model.motor
    if len(model.integrator):
        columns[2] = 1 + nq + nv + model.integrator
    if len(model.flex):
        columns[3] = 1 + model.flex
    return columns


def _servo(model: RobotModel) -> Array:
    """(5, 6): gear ratio, gains, torque limit."""
    drives = model.drives
    return np.array([drives.gear, drives.kp, drives.kd, drives.ki, drives.torque_limit])


def _limits(model: RobotModel) -> Array:
    """(3, 2, 6), lower and upper, in the order of WATCHED and the units of the truth."""
    drives = model.drives
    torque, speed = drives.torque_limit, drives.speed_limit
    return np.array([(-torque, torque), (-speed, speed), model.joint_range.T])


@njit(cache=True, nogil=True)
def _motors(
    initial_state: Array,
    states: Array,
    controls: Array,
    columns: np.ndarray,
    servo: Array,
    limits: Array,
    out: tuple[Array, Array, Array],
) -> np.ndarray:  # pragma: no cover - compiled
    """One pass over a run: angle, spring and torque of each axis, each (M, 6), into `out`.

    The drives deliver the servo's law, limited; it feeds back the speed at the start of a step.

    Returns:
        (3, 6), the first row at which each limit is not kept, in the order of WATCHED; or -1.
    """
    angle, spring, torque = out
    first = np.full((len(limits), columns.shape[1]), -1)
    for i in range(len(states)):
        state = initial_state if i == 0 else states[i - 1]
        for j in range(columns.shape[1]):
            gear, kp, kd, ki, limit = servo[:, j]
            q, speed = state[columns[0, j]], state[columns[1, j]]
            asked = (
                kp * (controls[i, 3 * j] - gear * q)
                + kd * (controls[i, 3 * j + 1] - gear * speed)
                + controls[i, 3 * j + 2]
            )
            if columns[2, j] >= 0:
                asked += ki * state[columns[2, j]]
            torque[i, j] = min(max(asked, -limit), limit)
            angle[i, j] = q
            spring[i, j] = 0.0 if columns[3, j] < 0 else state[columns[3, j]]
            for k, value in enumerate((torque[i, j], speed, q)):
                if first[k, j] < 0 and (value <= limits[k, 0, j] or value >= limits[k, 1, j]):
                    first[k, j] = i
    return first
