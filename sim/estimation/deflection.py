"""Deflection of an arm along a rigid motion, and the readings of an IMU that it explains.

    M d'' + D d' + (K + G) d = k(d) - load        k(d) = softening K clip(d, -l, l)

d are the angles of gears and structure, load is what the rigid motion takes from them. k holds the
lost motion: within +-l a gear is softer. Newmark's average acceleration adds no damping.
"""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from armside.arrays import Array
from armside.ilc.estimation.process import first_order_hold, simulate

from ..instruments.imu import ImuCfg, ImuSamples
from .elasticity import Elasticity
from .imu_health import REST
from .rigid_motion import RigidMotion

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

SUBSTEPS = 4
"""Steps a sample of the log: of 1 ms, which shifts a mode at 20 Hz by a thousandth."""
LARGEST = 0.1
"""Deflection [rad] that is none of an arm's, whose springs give way by thousandths."""
_NEWTON_STEPS = 60


@dataclass(frozen=True, eq=False)
class Deflection:
    """Deflection at the samples of the log, (N, n): angles [rad] and their derivatives."""

    angle: Array
    rate: Array
    acceleration: Array


def deflection(motion: RigidMotion, springs: Elasticity) -> Deflection:
    """From static equilibrium on. Raises FloatingPointError for springs that give way."""
    step = motion.period / SUBSTEPS
    K = motion.gradient + np.diag(springs.stiffness)
    D = np.diag(springs.damping)
    inverse = np.linalg.inv(motion.mass + 0.5 * step * D + 0.25 * step**2 * K)
    soft = springs.softening * springs.stiffness
    start = _at_rest(K[0], soft, springs.lost_motion, motion.load[0])
    found = _simulate(
        np.ascontiguousarray(K),
        springs.damping,
        np.ascontiguousarray(inverse, np.float64),
        soft,
        springs.lost_motion,
        np.ascontiguousarray(motion.load),
        motion.segment,
        start,
        step,
    )
    if not np.abs(found[0]).max() < LARGEST:
        raise FloatingPointError("the springs cannot carry the arm")
    return Deflection(*found)


def _at_rest(K: Array, soft: Array, lost: Array, load: Array) -> Array:
    """(n,), static deflection by Newton's method: a gear is within its lost motion or not."""
    d: Array = np.asarray(np.linalg.solve(K, -load), np.float64)
    for _ in range(_NEWTON_STEPS):
        inside = np.abs(d) < lost
        pull = np.where(inside, 0.0, soft * np.clip(d, -lost, lost))
        matrix = K - np.diag(soft * inside)
        following: Array = np.asarray(np.linalg.solve(matrix, pull - load), np.float64)
        if np.abs(following - d).max() < 1e-13:
            return following
        d = following
    return d


@njit(cache=True)
def _simulate(
    K: Array,
    D: Array,
    inverse: Array,
    soft: Array,
    lost: Array,
    load: Array,
    segment: np.ndarray,
    start: Array,
    step: float,
) -> tuple[Array, Array, Array]:  # pragma: no cover - compiled
    n_samples, n = load.shape
    d, v, a = start.copy(), np.zeros(n), np.zeros(n)
    angle, rate, acceleration = np.zeros((3, n_samples, n))
    angle[0] = d
    before, force = np.empty(n), np.empty(n)
    for i in range(1, n_samples):
        s = segment[i]
        for sub in range(SUBSTEPS):
            part = (sub + 1.0) / SUBSTEPS
            for j in range(n):
                before[j] = d[j] + step * v[j] + 0.25 * step * step * a[j]
            for j in range(n):
                # the soft range at the end of the step, as it is predicted
                there = before[j] + 0.25 * step * step * a[j]
                held = min(max(there, -lost[j]), lost[j])
                force[j] = soft[j] * held - load[i - 1, j] - part * (load[i, j] - load[i - 1, j])
                force[j] -= D[j] * (v[j] + 0.5 * step * a[j])
            for j in range(n):
                pull = 0.0
                for k in range(n):
                    pull += K[s, j, k] * before[k]
                force[j] -= pull
            for j in range(n):
                v[j] += 0.5 * step * a[j]
            for j in range(n):
                value = 0.0
                for k in range(n):
                    value += inverse[s, j, k] * force[k]
                a[j] = value
            for j in range(n):
                v[j] += 0.5 * step * a[j]
                d[j] = before[j] + 0.25 * step * step * a[j]
        angle[i], rate[i], acceleration[i] = d, v, a
    return angle, rate, acceleration


def explained(motion: RigidMotion, bent: Deflection, imu: ImuCfg) -> "CubicHermiteSpline":
    """(6,) readings behind the low-passes of a unit, over time."""
    from scipy.interpolate import CubicHermiteSpline

    # Of an ideal unit, from those at rest: [m/s^2], [rad/s].
    J, tilt, y = motion.imu_jacobian, motion.imu_gravity, motion.reading.copy()
    y[:, :3] += (J[:, :3] @ bent.acceleration[:, :, None] + tilt @ bent.angle[:, :, None])[..., 0]
    y[:, 3:] += (J[:, 3:] @ bent.rate[:, :, None])[..., 0]
    y -= y[0].copy()
    low, rate = np.empty_like(y), np.empty_like(y)
    for k, triad in enumerate((imu.accelerometer, imu.gyroscope)):
        channels = slice(3 * k, 3 * k + 3)
        states = simulate(*_low_pass(triad.bandwidth, motion.period), y[:, channels])
        low[:, channels], rate[:, channels] = states[:, :3], states[:, 3:]
    return CubicHermiteSpline(motion.time, low, rate)


@cache
def _low_pass(bandwidth: float, period: float) -> tuple[Array, Array, Array]:
    """Of a triad, sampled."""
    omega = 2.0 * np.pi * bandwidth
    one = [[0.0, 1.0], [-(omega**2), -np.sqrt(2.0) * omega]], [[0.0], [omega**2]]
    A, B = (np.asarray(np.kron(part, np.eye(3)), np.float64) for part in one)
    return first_order_hold(A, B, period)


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
