"""Error of the tool's motion over a whole record, rests too: position and acceleration in time.

The tool is compared with the programmed motion at the same instants, without any fit: a static
error counts. So measure Chen and Tomizuka, IEEE Trans. Control Systems Technology 22(4), 2014.
"""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array
from armside.kinematics.rotation import from_quaternion

from ..robot.recording import Truth

SETTLED = 2e-4
"""[m], distance from its final position within which the tool counts as settled. ESTIMATE"""
MOVES = 1e-6
"""Programmed speed [m/s] above which the tool is to move."""
WINDOW, ORDER = 21, 3
"""Samples of 1 ms and order of the polynomial by which a position error is differentiated."""


class Programmed(Protocol):
    """Programmed motion of the tool."""

    def position_at(self, time: ArrayLike) -> Array:
        """(..., 3) [m], base axes, at times [s]."""
        ...

    def is_on_contour(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Mask of the times [s] on a contour."""
        ...


@dataclass(frozen=True, kw_only=True)
class MotionError:
    """RMS and peaks of |p - p_programmed| [m] and |a - a_programmed| [m/s^2] of one record.

    Moving and at rest are what is programmed. An acceleration error is NaN where the tool's
    orientation is free, since none is programmed at the accelerometer then.
    """

    PER_STOP: ClassVar = ("settling", "residual_vibration")
    """Fields with a value for each stop."""

    tcp_rms: float
    tcp_rms_less_rest: float
    """Less its mean at rest before the first motion."""
    moving_tcp_rms: float
    rest_tcp_rms: float
    tcp_peak: float
    acceleration_rms: float
    """Ideal accelerometer at the tool, gravity removed, less the programmed acceleration: the
    definition of Chen and Tomizuka."""
    moving_acceleration_rms: float
    rest_acceleration_rms: float
    contour_acceleration_rms: float
    """Second derivative of the position error (Savitzky-Golay, 21 samples of 1 ms, order 3), on
    the contour alone."""
    settling: Array
    """(S,) [s], for each stop: from its programmed end to the last instant at which the tool is
    more than 0.2 mm from where that rest ends."""
    residual_vibration: Array
    """(S,) [m/s^2], RMS of the acceleration error in the rest after each stop."""


def motion_error(
    motion: Programmed, truth: Truth, mj: mujoco.MjModel, *, free_rotation: bool = False
) -> MotionError:
    """Error of a run from its ground truth, at 1 kHz. mj: with sites `tool0`, `imu` and gravity."""
    from scipy.signal import savgol_filter

    step = float(truth.time[1] - truth.time[0])
    truth = truth.every(max(1, round(1e-3 / step)))
    time, h = truth.time, float(truth.time[1] - truth.time[0])
    wanted = motion.position_at(time)
    error = truth.tool_position - wanted
    before, after = (motion.position_at(time + dt) for dt in (-h, h))
    moving = np.linalg.norm(after - before, axis=1) > 2.0 * h * MOVES
    excess = accelerations(truth, mj) - (after - 2.0 * wanted + before) / h**2
    if free_rotation:
        excess = np.full_like(excess, np.nan)
    off, vibration = (np.linalg.norm(each, axis=1) for each in (error, excess))
    at_first = int(moving.argmax()) if moving.any() else len(moving)
    # First sample of each rest after a motion and that after its last, two samples at least.
    edges = np.flatnonzero(np.diff(np.concatenate([[True], moving, [True]]))).reshape(-1, 2)
    rests = [(int(a), int(b)) for a, b in edges if b - a > 1 and a > 0]
    bend = np.full(len(time), np.nan)
    if len(error) >= WINDOW and np.isfinite(error).all():
        second = savgol_filter(error, WINDOW, ORDER, deriv=2, delta=h, axis=0)
        bend = np.linalg.norm(np.asarray(second), axis=1)
    return MotionError(
        tcp_rms=_rms(off),
        tcp_rms_less_rest=_rms(np.linalg.norm(error - error[: max(at_first, 1)].mean(0), axis=1)),
        moving_tcp_rms=_rms(off[moving]),
        rest_tcp_rms=_rms(off[~moving]),
        tcp_peak=float(off.max()),
        acceleration_rms=_rms(vibration),
        moving_acceleration_rms=_rms(vibration[moving]),
        rest_acceleration_rms=_rms(vibration[~moving]),
        contour_acceleration_rms=_rms(bend[motion.is_on_contour(time)]),
        settling=np.array([h * _settled(truth.tool_position[a:b]) for a, b in rests]),
        residual_vibration=np.array([_rms(vibration[a:b]) for a, b in rests]),
    )


def accelerations(truth: Truth, mj: mujoco.MjModel) -> Array:
    """(M, 3) [m/s^2], base axes: ideal accelerometer at the tool, gravity removed."""
    data = mujoco.MjData(mj)
    mujoco.mj_kinematics(mj, data)
    tool, imu = (data.site(name).xmat.reshape(3, 3) for name in ("tool0", "imu"))
    R_base_imu = from_quaternion(truth.tool_quaternion) @ (tool.T @ imu)
    return np.einsum("kij,kj->ki", R_base_imu, truth.imu_acceleration) + mj.opt.gravity


def _settled(position: Array) -> float:
    """Samples of a rest until the tool stays where it ends; NaN where that is not a number."""
    away = np.linalg.norm(position - position[-1], axis=1)
    outside = np.flatnonzero(away > SETTLED)
    return float(outside[-1] + 1 if len(outside) else 0) if np.isfinite(away).all() else np.nan


def _rms(size: Array) -> float:
    """Root of the mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(size**2))) if len(size) else np.nan
