"""What one run leaves behind, as plain arrays: the log of the robot cell, and the truth beside it.

Angles are arm-side radians unless a name says otherwise. The log is what a robot cell knows;
`Truth` is for evaluation only and is never handed to a law or an estimator.
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from armside.arrays import Array

from .drives import EXACT, GearError


def _freeze(record: object, n_rows: int, per_sample: dict[str, tuple[int, ...]]) -> None:
    """Check the shape of each array of a record and make it read-only."""
    for field in fields(record):  # type: ignore[arg-type]
        if field.name not in per_sample:
            continue
        value = np.asarray(getattr(record, field.name), dtype=np.float64)
        expected = (n_rows, *per_sample[field.name])
        if value.shape != expected:
            raise ValueError(f"{field.name} must have shape {expected}, got {value.shape}")
        value.setflags(write=False)
        object.__setattr__(record, field.name, value)


@dataclass(frozen=True, kw_only=True)
class Truth:
    """True state of the virtual robot, sampled at `time` (every physics step).

    All rows belong to the same instant: positions and IMU readings alike.
    """

    time: Array
    """(M,) [s]."""
    gear_angle: Array
    """(M, 6) [rad], arm side: what the gears make of the motor angles, before their springs."""
    spring_angle: Array
    """(M, 6) [rad], wind-up of the gear springs."""
    motor_torque: Array
    """(M, 6) [N m], motor side, what the drive delivers."""
    tool_position: Array
    """(M, 3) [m], TCP0 in base axes."""
    tool_quaternion: Array
    """(M, 4), w first, base to tool."""
    imu_acceleration: Array
    """(M, 3) [m/s^2], ideal specific force in the IMU frame."""
    imu_angular_velocity: Array
    """(M, 3) [rad/s], ideal, in the IMU frame."""
    qpos: Array
    """(M, nq), MuJoCo joint positions, for replay."""
    gear_error: GearError = EXACT
    """Of the gears, where `gear_angle` has one."""

    def __post_init__(self) -> None:
        six, three = (6,), (3,)
        shapes = {
            "time": (),
            "gear_angle": six,
            "spring_angle": six,
            "motor_torque": six,
            "tool_position": three,
            "tool_quaternion": (4,),
            "imu_acceleration": three,
            "imu_angular_velocity": three,
            "qpos": np.asarray(self.qpos).shape[1:],
        }
        _freeze(self, len(self.time), shapes)

    @cached_property
    def motor_angle(self) -> Array:
        """(M, 6) [rad], arm side."""
        return self.gear_angle - self.gear_error(self.gear_angle)

    @cached_property
    def flex_angle(self) -> Array:
        """(M, 6) [rad], arm minus motor, each axis."""
        return self.spring_angle + self.gear_error(self.gear_angle)

    def every(self, stride: int) -> "Truth":
        """Every how many rows of it."""
        rows = {
            field.name: getattr(self, field.name)[::stride]
            for field in fields(self)
            if field.name != "gear_error"
        }
        return replace(self, **rows)


@dataclass(frozen=True, kw_only=True)
class Recording:
    """One run of the virtual robot: the motor-side log at the log rate, and the truth.

    `limits_hit` names each limit that the run touched, as (limit, axis, first time [s]).
    """

    time: Array
    """(N,) [s], log instants."""
    reference: Array
    """(N, 6) [rad], r, arm-side motor angles asked for."""
    correction: Array
    """(N, 6) [rad], u, the ILC input."""
    motor_angle: Array
    """(N, 6) [rad], y, measured: quantised encoder."""
    motor_torque: Array
    """(N, 6) [N m], motor side, as the drive reports it."""
    truth: Truth
    limits_hit: tuple[tuple[str, int, float], ...] = ()

    def __post_init__(self) -> None:
        six = (6,)
        shapes = {
            "time": (),
            "reference": six,
            "correction": six,
            "motor_angle": six,
            "motor_torque": six,
        }
        _freeze(self, len(self.time), shapes)

    @property
    def error(self) -> Array:
        """e = r - y, shape (N, 6) [rad], arm-side motor angles. Thesis (9.2)."""
        return self.reference - self.motor_angle
