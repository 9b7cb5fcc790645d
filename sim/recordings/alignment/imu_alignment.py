"""Alignment of an IMU with the encoders: clock, delays, scale and mounting, lever, biases, gravity.

    gyro(t + tau_g)          = M_g R^T omega + b_g
    accelerometer(t + tau_a) = M_a (R^T (a - g) + (dw/dt x r + w x (w x r))) + b_a

M are free 3x3 matrices: scale, cross-axis sensitivity and a mounting of any angle. They are linear
given clock and lever, so the search is over those alone (variable projection).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from armside.arrays import Array

from ..recorded_motion import Stream
from .checks import check_pair, check_readings, check_sensor
from .encoder_motion import RATE, EncoderMotion, coarse_lag, even, lowpass, sampled

GRAVITY = np.array([0.0, 0.0, -9.81])
"""[m/s^2] in base axes. ESTIMATE of the place; the scale of the accelerometer takes the rest."""
SLOW = 8.0
"""[Hz] Band of the fit."""
STRIDE = 4
"""Samples of the grid for one of the fit."""
MARGIN = 1.0
"""[s] At both ends, where filters have not settled."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ImuAlignment:
    """Constants of one recording that take readings of its IMU to base axes."""

    gyro_delay: float
    accelerometer_delay: float
    """[s], the IMU's clock minus the encoders' in the middle of the recording, delay included."""
    rate: float
    """Rate of the IMU's clock less that of the encoders, relative."""
    M_gyro: Array
    M_accelerometer: Array
    """(3, 3), tool axes to readings: mounting and scale."""
    gyro_bias: Array
    accelerometer_bias: Array
    """(3,) [rad/s] and [m/s^2]."""
    lever: Array
    """(3,) [m], the IMU in the tool frame."""
    gravity: Array
    """(3,) [m/s^2], base axes."""

    @property
    def R_imu_tool(self) -> Array:
        """(3, 3), rotation of the mounting: the orthogonal part of M_gyro."""
        u, _, vt = np.linalg.svd(self.M_gyro)
        return u @ vt

    def clock(self, motion: EncoderMotion, delay: float) -> Array:
        """(M,) [s], times of the IMU's clock at the samples of the motion."""
        return motion.time + delay + self.rate * (motion.time - motion.time.mean())

    def residual(self, motion: EncoderMotion, imu: Stream) -> Array:
        """(M, 6): measured less encoders' acceleration [m/s^2] and angular rate, base axes."""
        return self.measured(motion, imu) - self.predicted(motion)

    def measured(self, motion: EncoderMotion, imu: Stream) -> Array:
        """(M, 6), specific force [m/s^2] and angular rate [rad/s] of the IMU in base axes."""
        force = sampled(imu.time, imu.values[:, :3], self.clock(motion, self.accelerometer_delay))
        gyro = sampled(imu.time, imu.values[:, 3:], self.clock(motion, self.gyro_delay))
        force = (force - self.accelerometer_bias) @ np.linalg.inv(self.M_accelerometer).T
        gyro = (gyro - self.gyro_bias) @ np.linalg.inv(self.M_gyro).T
        to_base = np.einsum("nij,knj->nki", motion.R, np.stack([force, gyro]))
        return to_base.reshape(-1, 6)

    def predicted(self, motion: EncoderMotion) -> Array:
        """(M, 6), the same by the encoders."""
        omega, alpha = motion.velocity[:, 3:], motion.acceleration[:, 3:]
        r = motion.lever(self.lever)
        turning = np.cross(alpha, r) + np.cross(omega, np.cross(omega, r))
        force = motion.acceleration[:, :3] + turning - self.gravity
        return np.concatenate([force, omega], axis=1)

    def covered(self, motion: EncoderMotion, imu: Stream) -> NDArray[np.bool_]:
        """(M,) bool, samples of the motion that the IMU saw."""
        t = self.clock(motion, self.accelerometer_delay)
        return (t > imu.time[0]) & (t < imu.time[-1])


def align_imu(
    motion: EncoderMotion, imu: Stream, fraction: float = 1.0, *, level: bool = True
) -> ImuAlignment:
    """Alignment by least squares on a fraction of the recording, from its start.

    level: the base is taken as level; otherwise its tilt against gravity is fitted too.

    Raises ValueError for an IMU that did not see this motion, or wrong units or axes.
    """
    check_readings(imu)
    R, omega = motion.R, motion.velocity[:, 3:]
    own_speed, speed = (np.linalg.norm(w, axis=1) for w in (imu.values[:, 3:], omega))
    last = int(fraction * len(motion.time))
    start = coarse_lag("IMU", (imu.time, own_speed), (motion.time[:last], speed[:last]))
    slow = _Slow(motion, imu, last)
    w = np.einsum("nji,nj->ni", R, omega)
    turned = slow.predicted(w)

    def of_gyro(x: Array) -> Array:
        return slow.fit(turned, slow.reading(x[0], x[1])[:, 3:])[0].ravel()

    around = start + np.arange(-0.3, 0.31, 0.02)
    start = min(around, key=lambda t: np.linalg.norm(of_gyro(np.array([t, 0.0]))))
    gyro_delay, rate = least_squares(of_gyro, [start, 0.0], x_scale=[1e-2, 1e-4]).x
    M_gyro, gyro_bias = slow.fit(turned, slow.reading(gyro_delay, rate)[:, 3:])[1:]
    check_sensor("angular rate", M_gyro)
    alpha = np.einsum("nji,nj->ni", R, motion.acceleration[:, 3:])
    force = slow.predicted(np.einsum("nji,nj->ni", R, motion.acceleration[:, :3] - GRAVITY))
    turning = _cross(alpha) + _cross(w) @ _cross(w)
    levers, axes = (slow.predicted(x.reshape(-1, 9)).reshape(-1, 3, 3) for x in (turning, R))

    def of_force(x: Array) -> tuple[Array, Array, Array]:
        tilted = axes.transpose(0, 2, 1) @ (_tilted(x[4:]) - GRAVITY)
        return slow.fit(force + levers @ x[1:4] - tilted, slow.reading(x[0], rate)[:, :3])

    first = np.array([gyro_delay, 0.0, 0.0, 0.0] + ([] if level else [0.0, 0.0]))
    scale = np.array([1e-2, 0.1, 0.1, 0.1, 1e-2, 1e-2])[: len(first)]
    found = least_squares(lambda x: of_force(x)[0].ravel(), first, x_scale=scale).x
    _, M_accelerometer, accelerometer_bias = of_force(found)
    check_sensor("specific force", M_accelerometer)
    check_pair(M_gyro, M_accelerometer, accelerometer_bias)
    return ImuAlignment(
        gyro_delay=float(gyro_delay),
        accelerometer_delay=float(found[0]),
        rate=float(rate),
        M_gyro=M_gyro,
        M_accelerometer=M_accelerometer,
        gyro_bias=gyro_bias,
        accelerometer_bias=accelerometer_bias,
        lever=found[1:4],
        gravity=_tilted(found[4:]),
    )


def _tilted(tilt: Array) -> Array:
    """Gravity (3,) [m/s^2] in the axes of a base that is tilted by (2,) [rad] in x and y."""
    if not len(tilt):
        return GRAVITY
    down = np.array([tilt[0], tilt[1], -1.0])
    return np.linalg.norm(GRAVITY) * down / np.linalg.norm(down)


class _Slow:
    """Readings and predictions of one recording in the band of the fit, at fewer samples."""

    def __init__(self, motion: EncoderMotion, imu: Stream, last: int) -> None:
        time, values = even(imu.time, imu.values)
        self._spline = CubicSpline(time, lowpass(values, SLOW))
        self._ends = (time[0] + MARGIN, time[-1] - MARGIN)
        margin = int(MARGIN * RATE)
        self._rows = slice(margin, last - margin, STRIDE)
        self._time, self._middle = motion.time[self._rows], motion.time.mean()
        self._inside = np.ones(len(self._time), dtype=bool)

    def predicted(self, values: Array) -> Array:
        return lowpass(values, SLOW)[self._rows]

    def reading(self, delay: float, rate: float) -> Array:
        t = self._time + delay + rate * (self._time - self._middle)
        self._inside = (t > self._ends[0]) & (t < self._ends[1])
        return self._spline(np.clip(t, *self._ends))

    def fit(self, ideal: Array, reading: Array) -> tuple[Array, Array, Array]:
        """Residual (K, 3), zero outside of the IMU's record, M (3, 3) and bias (3,)."""
        weight = self._inside[:, None]
        columns = weight * np.column_stack([ideal, np.ones(len(ideal))])
        solution: Any = np.linalg.lstsq(columns, weight * reading, rcond=None)[0]
        found: Array = solution
        return weight * reading - columns @ found, found[:3].T, found[3]


def _cross(v: Array) -> Array:
    x, y, z = v.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
