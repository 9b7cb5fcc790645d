"""Motion of an arm by its encoders, on an even grid of time, and the offset of another clock."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, correlate, sosfiltfilt

from armside.arrays import Array
from armside.kinematics import CompiledRobot

from ..recorded_motion import Stream

RATE, STEP = 100.0, 0.01
"""[Hz], [s] Of the grid."""
SMOOTH = 25.0
"""[Hz] Low-pass of the motor angles before they are differentiated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EncoderMotion:
    """Motor angles on an even grid, and the kinematics of the nominal robot there."""

    time: Array
    """(M,) [s], by the encoders' clock."""
    phi: Array
    rate: Array
    """(M, n) [rad] and [rad/s]."""
    T: Array
    """(M, 4, 4), base to tool."""
    J: Array
    """(M, 6, n), (v, omega) of the tool origin in base axes."""
    acceleration: Array
    """(M, 6), (v_dot, omega_dot) of the tool origin in base axes, without gravity."""

    @property
    def R(self) -> Array:
        """(M, 3, 3), base to tool."""
        return self.T[:, :3, :3]

    @cached_property
    def velocity(self) -> Array:
        """(M, 6), (v, omega) of the tool origin in base axes."""
        return np.einsum("nij,nj->ni", self.J, self.rate)

    def lever(self, r: Array) -> Array:
        """(M, 3) [m], a point r (3,) of the tool frame from its origin, in base axes."""
        return self.R @ r

    def point_jacobian(self, r: Array) -> Array:
        """(M, 3, n), velocity of a point r (3,) [m] of the tool frame, in base axes."""
        return self.J[:, :3] + np.cross(self.J[:, 3:], self.lever(r)[:, :, None], axis=1)


def encoder_motion(robot: CompiledRobot, encoders: Stream) -> EncoderMotion:
    """Motion by the encoders; a spline over the stamps, low-passed without phase."""
    n, given = robot.robot.n_joints, encoders.values.shape[1]
    if given != n:
        raise ValueError(f"{robot.robot.name} has {n} motors, the recording has {given}")
    own = 1.0 / float(np.median(np.diff(encoders.time)))
    if own < 2.0 * SMOOTH:
        raise ValueError(f"encoders at {own:.3g} Hz; at least {2.0 * SMOOTH:g} Hz are needed")
    time, angles = even(encoders.time, encoders.values)
    phi = lowpass(angles, SMOOTH)
    spline = CubicSpline(time, phi)
    rate = spline(time, 1)
    return EncoderMotion(
        time=time,
        phi=phi,
        rate=rate,
        T=robot.pose(phi),
        J=robot.jacobian(phi),
        acceleration=robot.acceleration(phi, rate, spline(time, 2)),
    )


def even(time: Array, values: Array, step: float = STEP) -> tuple[Array, Array]:
    """Even times [s], and a signal there."""
    grid = np.arange(time[0], time[-1], step)
    return grid, CubicSpline(time, values)(grid)


def sampled(time: Array, values: Array, wanted: Array) -> Array:
    """A signal at other times [s], held beyond its ends."""
    return CubicSpline(time, values)(np.clip(wanted, time[0], time[-1]))


def lowpass(x: Array, cutoff: float, rate: float = RATE) -> Array:
    """Zero-phase Butterworth low-pass of the columns of x; unchanged above the Nyquist rate."""
    if cutoff >= 0.45 * rate:
        return x
    return sosfiltfilt(butter(2, 2.0 * cutoff / rate, output="sos"), x, axis=0)


def bandpass(x: Array, low: float, high: float) -> Array:
    """Zero-phase Butterworth band-pass of 4th order of the columns of x, on the grid."""
    band = (2.0 * low / RATE, 2.0 * high / RATE)
    return sosfiltfilt(butter(4, band, "bandpass", output="sos"), x, axis=0)


CORRELATED = 0.3
"""Correlation below which the two did not see the same motion."""
OVERLAP = 0.5
"""Of the shorter record, that both must have seen."""


def coarse_lag(name: str, own: tuple[Array, Array], robot: tuple[Array, Array]) -> float:
    """Own clock minus the robot's [s] by times (K,) [s] and speeds (K,) of both, or ValueError."""
    likeness, n = _likeness(own, robot)
    best = int(np.argmax(likeness))
    if not likeness[best] > CORRELATED:
        text = f"{name} and encoders did not see the same motion at any offset of their clocks"
        raise ValueError(f"{text} (correlation {likeness[best]:.2f})")
    return float((best - n + 1) * STEP + own[0][0] - robot[0][0])


def likeness_at_best_lag(own: tuple[Array, Array], robot: tuple[Array, Array]) -> float:
    """Largest correlation of the two over all lags, -1 to 1."""
    return float(_likeness(own, robot)[0].max())


def _likeness(own: tuple[Array, Array], robot: tuple[Array, Array]) -> tuple[Array, int]:
    """Correlation at each lag, and samples of the robot's signal on the even grid."""
    a, b = (x - x.mean() for _, x in (even(*own), even(*robot)))
    product = correlate(a, b, "full", "fft")
    overlap = correlate(np.ones_like(a), np.ones_like(b), "full", "fft")
    energy = correlate(a**2, np.ones_like(b), "full", "fft")
    energy *= correlate(np.ones_like(a), b**2, "full", "fft")
    floor = np.finfo(float).eps * energy.max()
    likeness = product / np.sqrt(np.maximum(energy, max(floor, np.finfo(float).tiny)))
    likeness[overlap < OVERLAP * min(len(a), len(b))] = -1.0
    return likeness, len(b)
