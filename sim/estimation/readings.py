"""Readings of an IMU that an arm's motion explains, and what is left of those it took."""

from typing import TYPE_CHECKING

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.process import first_order_hold, simulate

from ..instruments.imu import ImuCfg, ImuSamples
from .deflection import Deflection
from .imu_health import REST
from .rigid_motion import RigidMotion

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline


def ideal_readings(motion: RigidMotion, bent: Deflection) -> Array:
    """(N, 6) [m/s^2], [rad/s], of an ideal unit, from those at rest."""
    J, tilt = motion.imu_jacobian, motion.imu_gravity
    y = motion.reading.copy()
    y[:, :3] += (J[:, :3] @ bent.acceleration[:, :, None] + tilt @ bent.angle[:, :, None])[..., 0]
    y[:, 3:] += (J[:, 3:] @ bent.rate[:, :, None])[..., 0]
    return y - y[0]


def explained(motion: RigidMotion, bent: Deflection, imu: ImuCfg) -> "CubicHermiteSpline":
    """(6,) readings behind the low-passes of a unit, over time."""
    from scipy.interpolate import CubicHermiteSpline

    y = ideal_readings(motion, bent)
    low, rate = np.empty_like(y), np.empty_like(y)
    for k, triad in enumerate((imu.accelerometer, imu.gyroscope)):
        omega = 2.0 * np.pi * triad.bandwidth
        one = np.array([[0.0, 1.0], [-(omega**2), -np.sqrt(2.0) * omega]])
        three = (
            np.kron(one, np.eye(3)).astype(np.float64),
            np.kron([[0.0], [omega**2]], np.eye(3)).astype(np.float64),
        )
        channels = slice(3 * k, 3 * k + 3)
        states = simulate(*first_order_hold(*three, motion.period), y[:, channels])
        low[:, channels], rate[:, channels] = states[:, :3], states[:, 3:]
    return CubicHermiteSpline(motion.time, low, rate)


def residual(
    samples: ImuSamples, known: "CubicHermiteSpline", clock_offset: float, mounting: Array
) -> tuple[Array, Array]:
    """Readings (K, 6) minus those explained, and biases (6,), their mean at rest.

    mounting: (3,) [rad], rotation of the IMU's housing: it reads y - mounting x y.
    """
    at = samples.time + clock_offset
    y = known(np.clip(at, known.x[0], known.x[-1]))
    turned = np.hstack([np.cross(mounting, v) for v in np.split(y, 2, axis=1)])
    left = np.hstack((samples.acceleration, samples.angular_velocity)) - y + turned
    return left, np.nanmean(left[at < REST], axis=0)
