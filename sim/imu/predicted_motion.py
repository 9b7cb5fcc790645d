"""Motion of an IMU on the robot, predicted from motor angles: thesis 5.1, (5.10), (5.11)."""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from armside import kinematics
from armside.arrays import Array, check_numbers
from armside.ilc.filters import RecordFilter

from ..instruments.imu import ACCELEROMETER, GYROSCOPE


class Scheme(Enum):
    """Difference quotient of the first derivative; the second is central in both."""

    FORWARD = "forward"
    """Thesis (5.6): half a sample early."""
    CENTRAL = "central"


def difference_quotients(phi: Array, h: float, scheme: Scheme) -> tuple[Array, Array]:
    """First and second derivative of samples (N, n) every h [s], as if at rest beyond the ends.
    Thesis (5.6)."""
    if len(phi) < 3:
        raise ValueError(f"difference quotients need at least 3 samples, got {len(phi)}")
    padded = np.concatenate([phi[:1], phi, phi[-1:]])
    before, now, after = padded[:-2], padded[1:-1], padded[2:]
    second = (after - 2.0 * now + before) / h**2
    if scheme is Scheme.FORWARD:
        return (after - now) / h, second
    return (after - before) / (2.0 * h), second


def resample(time: Array, values: Array, at: Array) -> Array:
    """Samples (N, n) at other instants by a cubic spline, at rest beyond the ends: the low-pass
    that follows is far below both rates."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(time, values, bc_type="clamped")
    return spline(np.clip(at, time[0], time[-1]))


class Order(Enum):
    """Order of low-pass and kinematics; the map from joint rates to the sensor is not linear."""

    FILTER_THEN_MAP = "filter-then-map"
    """Joint rates are filtered. Thesis 5.1.2."""
    MAP_THEN_FILTER = "map-then-filter"
    """The prediction is filtered like the measurement: both sides have the same distortion."""


@dataclass(frozen=True, kw_only=True)
class PredictedMotion:
    """Predicted motion of the IMU in base axes, SI, accelerations without gravity: R (K, 3, 3),
    others (K, 3)."""

    R_base_imu: Array
    angular_velocity: Array
    acceleration: Array


def predict(
    robot: kinematics.Robot,
    phi: Array,
    period: float,
    low_pass: RecordFilter,
    *,
    order: Order = Order.FILTER_THEN_MAP,
    scheme: Scheme = Scheme.FORWARD,
) -> PredictedMotion:
    """Motion of the last frame of `robot`, e.g. `IRB1400_IMU`, by motor angles phi (K, n) [rad],
    arm side, every `period` [s]."""
    compiled = kinematics.compile(robot)
    phi = np.ascontiguousarray(phi)
    rate, acceleration = difference_quotients(phi, period, scheme)
    if order is Order.FILTER_THEN_MAP:
        rate, acceleration = low_pass(rate), low_pass(acceleration)
    omega = np.einsum("kij,kj->ki", compiled.jacobian(phi)[:, 3:], rate)
    a = compiled.acceleration(phi, rate, acceleration)[:, :3]
    if order is Order.MAP_THEN_FILTER:
        omega, a = low_pass(omega), low_pass(a)
    R = compiled.pose(phi)[:, :3, :3]
    return PredictedMotion(R_base_imu=R, angular_velocity=omega, acceleration=a)


class Compensation(Enum):
    """Compensation of the measurement for gravity and offsets."""

    MEAN_AT_REST = "mean-at-rest"
    """Gravity in base axes and the mean in the zero pose are subtracted. Thesis 5.1.1."""
    ACTUAL_ORIENTATION = "actual-orientation"
    """Mounting error and biases are fitted with the orientation of every sample, which the thesis
    names as future work."""


@dataclass(frozen=True, kw_only=True)
class ProcessingCfg:
    """Processing that makes measurement and prediction comparable."""

    cutoff: float = 5.0
    """Zero-phase second-order low-pass of both sides [Hz]. Thesis 5.1.1."""
    order: Order = Order.FILTER_THEN_MAP
    scheme: Scheme = Scheme.FORWARD
    compensation: Compensation = Compensation.ACTUAL_ORIENTATION
    accelerometer_delay: float = 1e-3 * round(1e3 * ACCELEROMETER.delay, 3)
    """Known delay of the sensor's own low-pass [s], to a microsecond; 0 leaves it in."""
    gyroscope_delay: float = 1e-3 * round(1e3 * GYROSCOPE.delay, 3)
    search: float = 0.5
    """Largest clock offset in the search [s]."""

    def __post_init__(self) -> None:
        check_numbers(self, "cutoff", "accelerometer_delay", "gyroscope_delay", nan=True)
        if not (np.isfinite(self.cutoff) and self.cutoff > 0.0):
            raise ValueError(f"cutoff must be > 0 Hz, got {self.cutoff:g}")
        for name in ("accelerometer_delay", "gyroscope_delay"):
            delay = getattr(self, name)
            if not 0.0 <= delay <= self.search:
                most = f"from 0 to {1e3 * self.search:g} ms, the search of the clock offset"
                raise ValueError(f"{name} must be {most}, got {1e3 * delay:g}")

    @property
    def as_in_the_thesis(self) -> "ProcessingCfg":
        """Gravity by the mean at rest, and clocks synchronised by one sensor for both."""
        return replace(
            self, compensation=Compensation.MEAN_AT_REST, accelerometer_delay=self.gyroscope_delay
        )

    @property
    def best(self) -> "ProcessingCfg":
        """Both sides filtered alike, and no time shift between rate and angle."""
        return replace(self, order=Order.MAP_THEN_FILTER, scheme=Scheme.CENTRAL)
