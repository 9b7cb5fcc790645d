"""Motion of an arm by its encoders, on an even grid of time, and its kinematics."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.kinematics import CompiledRobot

from ..measured.motion import Stream

RATE = 100.0
"""[Hz] Of the grid."""
SMOOTH = 25.0
"""[Hz] Low-pass of the motor angles before they are differentiated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointMotion:
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


def joint_motion(robot: CompiledRobot, encoders: Stream) -> JointMotion:
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
    return JointMotion(
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
