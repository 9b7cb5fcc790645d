"""Record of one run: the log of the robot cell, and the ground truth.

Angles are arm-side radians unless a name says otherwise. `Truth` is for evaluation only and never
given to a law or an estimator.
"""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from armside.arrays import Array

from ..notes import Cause, Note
from .drives import EXACT, GearError


def _freeze(record: "Truth | Recording", **shape_of_row: tuple[int, ...]) -> None:
    """Check the shape of the arrays of a record and make them read-only."""
    for name, shape in shape_of_row.items():
        value = np.asarray(getattr(record, name), dtype=np.float64)
        if value.shape != (expected := (len(record.time), *shape)):
            raise ValueError(f"{name} must have shape {expected}, got {value.shape}")
        value.setflags(write=False)
        object.__setattr__(record, name, value)


@dataclass(frozen=True, kw_only=True)
class Truth:
    """Ground truth of the virtual robot at each physics step.

    All rows belong to the same instant: positions and IMU readings alike.
    """

    time: Array
    """(M,) [s]."""
    gear_angle: Array
    """(M, n) [rad], arm side, output angles of the gears before their springs."""
    spring_angle: Array
    """(M, n) [rad], wind-up of the gear springs."""
    motor_torque: Array
    """(M, n) [N m], motor side, delivered by the drives."""
    tool_position: Array
    tool_quaternion: Array
    """(M, 3) [m], TCP0 in base axes, and (M, 4), w first, base to tool."""
    imu_acceleration: Array
    imu_angular_velocity: Array
    """(M, 3) [m/s^2], ideal specific force, and (M, 3) [rad/s], ideal, in the IMU frame."""
    qpos: Array
    """(M, nq), MuJoCo joint positions, for replay."""
    gear_error: GearError = EXACT
    """Transmission error contained in `gear_angle`."""

    def __post_init__(self) -> None:
        axes = np.shape(self.gear_angle)[1:]
        motors = dict.fromkeys(("gear_angle", "spring_angle", "motor_torque"), axes)
        vectors = dict.fromkeys(("tool_position", "imu_acceleration", "imu_angular_velocity"), (3,))
        qpos = np.shape(self.qpos)[1:]
        _freeze(self, time=(), **motors, **vectors, tool_quaternion=(4,), qpos=qpos)

    @cached_property
    def motor_angle(self) -> Array:
        """(M, n) [rad], arm side."""
        return self.gear_angle - self.gear_error(self.gear_angle)

    @cached_property
    def flex_angle(self) -> Array:
        """(M, n) [rad], arm minus motor, each axis."""
        return self.spring_angle + self.gear_error(self.gear_angle)

    def every(self, stride: int) -> "Truth":
        """Every `stride`-th sample."""
        names = (field.name for field in fields(self) if field.name != "gear_error")
        return replace(self, **{name: getattr(self, name)[::stride] for name in names})


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Record of one run of the virtual robot: motor-side log at the log rate, and ground truth.

    `limits_hit` names each limit that the run touched, as (limit, axis, first time [s]).
    """

    time: Array
    """(N,) [s], log instants."""
    reference: Array
    correction: Array
    motor_angle: Array
    """(N, n) [rad], arm side: r, the ILC input u, and y as measured by the quantised encoder."""
    motor_torque: Array
    """(N, n) [N m], motor side, reported by the drives."""
    truth: Truth
    limits_hit: tuple[tuple[str, int, float], ...] = ()

    def __post_init__(self) -> None:
        names = ("reference", "correction", "motor_angle", "motor_torque")
        _freeze(self, time=(), **dict.fromkeys(names, self.truth.gear_angle.shape[1:]))

    @property
    def n_axes(self) -> int:
        """Number of axes."""
        return self.reference.shape[1]

    @property
    def error(self) -> Array:
        """e = r - y, shape (N, n) [rad], arm-side motor angles. Thesis (9.2)."""
        return self.reference - self.motor_angle


_MEANING = {
    "torque": "drives saturate: torque limit of axis {axes}",
    "speed": "speed limit of axis {axes} is reached",
    "joint": "hard stop of axis {axes} is reached",
}


_MOVES = 1e-6
"""[rad] or [m], range of a reference beyond which it is a motion: that of 10 um at 10 m."""


def every_drive_saturates(recording: Recording) -> bool:
    """True where each axis that is to move, one at least, reached its torque limit."""
    at_limit = {axis for limit, axis, _ in recording.limits_hit if limit == "torque"}
    moved = np.flatnonzero(np.ptp(recording.reference, axis=0) > _MOVES) + 1
    return moved.size > 0 and at_limit.issuperset(moved.tolist())


def saturation(recording: Recording) -> Iterable[Note]:
    """A note for each kind of limit, with its axes."""
    for limit, meaning in _MEANING.items():
        axes = [str(axis) for name, axis, _ in recording.limits_hit if name == limit]
        if axes:
            yield Note(cause=Cause.SATURATION, text=meaning.format(axes=", ".join(axes)))
