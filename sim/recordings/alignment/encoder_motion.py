"""Motion of an arm by its encoders, on an even grid of time, and the offset of another clock."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.kinematics import CompiledRobot

from ..recorded_motion import Stream

RATE = 100.0
"""[Hz] Of the grid."""
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
    """Motion by the encoders; a spline over the stamps, low-passed without phase.

    Raises:
        ValueError: fewer motors than the robot has, or sampled too slowly.
    """
    from scipy.interpolate import CubicSpline

    n, given = robot.robot.n_joints, encoders.values.shape[1]
    if given != n:
        raise ValueError(f"{robot.robot.name} has {n} motors, the recording has {given}")
    own = 1.0 / float(np.median(np.diff(encoders.time)))
    if own < 2.0 * SMOOTH:
        raise ValueError(f"encoders at {own:.3g} Hz; at least {2.0 * SMOOTH:g} Hz are needed")
    time = np.arange(encoders.time[0], encoders.time[-1], 1.0 / RATE)
    phi = lowpass(CubicSpline(encoders.time, encoders.values)(time), SMOOTH)
    spline = CubicSpline(time, phi)
    rate, second = spline(time, 1), spline(time, 2)
    return EncoderMotion(
        time=time,
        phi=phi,
        rate=rate,
        T=robot.pose(phi),
        J=robot.jacobian(phi),
        acceleration=robot.acceleration(phi, rate, second),
    )


def lowpass(x: Array, cutoff: float, rate: float = RATE) -> Array:
    """Zero-phase Butterworth low-pass of the columns of x; unchanged above the Nyquist rate."""
    from scipy.signal import butter, sosfiltfilt

    if cutoff >= 0.45 * rate:
        return x
    return sosfiltfilt(butter(2, 2.0 * cutoff / rate, output="sos"), x, axis=0)


def bandpass(x: Array, low: float, high: float) -> Array:
    """Zero-phase Butterworth band-pass of 4th order of the columns of x, on the grid."""
    from scipy.signal import butter, sosfiltfilt

    band = (2.0 * low / RATE, 2.0 * high / RATE)
    return sosfiltfilt(butter(4, band, "bandpass", output="sos"), x, axis=0)


STEP = 0.01
"""[s] Of the search."""
CORRELATED = 0.3
"""Correlation below which the two did not see the same motion."""
OVERLAP = 0.5
"""Of the shorter record, that both must have seen."""


def coarse_lag(name: str, own: tuple[Array, Array], robot: tuple[Array, Array]) -> float:
    """Own clock minus the robot's clock at the same instant [s].

    Args:
        name: of the instrument, for the error.
        own: time (K,) [s] and speed (K,). robot: the same by the robot, at its clock.

    Raises:
        ValueError: no lag makes the two alike.
    """
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
    from scipy.signal import correlate

    a, b = (_even(*signal) for signal in (own, robot))
    product = correlate(a, b, "full", "fft")
    overlap = correlate(np.ones_like(a), np.ones_like(b), "full", "fft")
    energy = correlate(a**2, np.ones_like(b), "full", "fft")
    energy *= correlate(np.ones_like(a), b**2, "full", "fft")
    floor = np.finfo(float).eps * energy.max()
    likeness = product / np.sqrt(np.maximum(energy, max(floor, np.finfo(float).tiny)))
    likeness[overlap < OVERLAP * min(len(a), len(b))] = -1.0
    return likeness, len(b)


def _even(time: Array, values: Array) -> Array:
    from scipy.interpolate import CubicSpline

    grid = np.arange(time[0], time[-1], STEP)
    even = CubicSpline(time, values)(grid)
    return even - even.mean()
