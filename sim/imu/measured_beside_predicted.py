"""Comparison of the measured with the predicted motion of the IMU: thesis 5.1 as one function."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside import kinematics
from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..instruments.imu import ImuSamples
from ..instruments.noise import rate_of
from . import compensation
from .compensation import cross_matrices
from .predicted_motion import (
    Compensation,
    Order,
    PredictedMotion,
    ProcessingCfg,
    Scheme,
    predict,
    resample,
)

COARSE = 0.01  # Grid of the first search [s], well below the time scale of the rotation
READING = 0.02  # Standard deviation of a gyro reading about its prediction [rad/s]
MOUNTING = np.deg2rad(2.0)  # Standard deviation of the gyro's mounting error about each axis [rad]


def clock_offset(
    imu_time: Array,
    gyro: Array,
    robot_time: Array,
    predicted: Array,
    *,
    search: float = 0.5,
    gyro_delay: float = 0.0,
) -> float:
    """Robot time when the IMU's clock shows 0 [s].

    Least squares of gyro(t) = predicted(t + offset - gyro_delay) over the offset: on a grid, then
    by Gauss-Newton steps on a spline, together with the bias and the mounting error of the gyro.

    Args:
        imu_time: (K,) [s], by the IMU's clock. gyro: (K, 3) [rad/s], its own frame; a small
        mounting error does no harm. robot_time: (N,) [s], by the robot's clock; the robot rests at
        both ends. predicted: (N, 3) [rad/s], the same rotation by the motor angles.
        search: largest offset [s], either sign. gyro_delay: known delay of the gyro's
        low-pass [s], which the data cannot separate from an offset.

    Raises:
        ValueError: the sensor does not rotate, or no offset within the search fits.
    """
    from scipy.interpolate import CubicSpline

    spread = predicted.std()
    if not spread > 10.0 * np.finfo(float).eps:
        raise ValueError("clocks cannot be synchronised: the IMU does not rotate in this record")
    spline = CubicSpline(robot_time, predicted, bc_type="clamped")

    def at(tau: float, derivative: int = 0) -> Array:
        t = imu_time + tau
        inside = (t >= robot_time[0]) & (t <= robot_time[-1])
        values = spline(np.clip(t, robot_time[0], robot_time[-1]), derivative)
        return values if derivative == 0 else values * inside[:, np.newaxis]

    grid = np.arange(-search, search + COARSE / 2, COARSE)
    apart = (gyro - at(tau) for tau in grid)
    cost = [np.sum((each - each.mean(axis=0)) ** 2) for each in apart]
    best = int(np.argmin(cost))
    if best in (0, len(grid) - 1):
        raise ValueError(f"no clock offset within +-{search:g} s fits; search further")
    return _refined(float(grid[best]), gyro, at) + gyro_delay


def _refined(tau: float, gyro: Array, at: Callable[..., Array]) -> float:
    """Gauss-Newton over offset, mounting error and bias: gyro = w(t + tau) + w x delta + bias.

    Without delta, a mounting error would appear as an offset wherever the axis of rotation changes.
    """
    # Prior of delta relative to the readings' noise: about one axis it is not observable.
    prior = np.diag([0.0, *np.full(3, (READING / MOUNTING) ** 2)])
    for _ in range(10):
        omega, slope = at(tau), at(tau, 1)
        J = np.concatenate([slope[:, :, np.newaxis], cross_matrices(omega)], axis=2)
        J = J - J.mean(axis=0)
        information = np.einsum("kia,kib->ab", J, J) + prior
        apart = gyro - omega
        score = np.einsum("kia,ki->a", J, apart - apart.mean(axis=0))
        tau += float(np.linalg.solve(information, score)[0])
    return tau


SYNC_CUTOFF = 40.0
"""Low-pass of the encoder's steps before synchronisation, above the motion's content [Hz]."""
REST_RATE = 0.005
"""Below this angular velocity, and the acceleration below, the sensor is at rest [rad/s]."""
REST_ACCELERATION = 0.2  # [m/s^2]; above what encoder noise predicts at rest


@dataclass(frozen=True)
class ImuComparison:
    """Measured and predicted motion of the IMU in base axes, filtered alike.

    Angular velocities (K, 3) [rad/s], accelerations (K, 3) [m/s^2] without gravity.
    """

    time: Array
    """(K,) [s], IMU samples by the robot's clock."""
    angular_velocity_measured: Array
    angular_velocity_predicted: Array
    acceleration_measured: Array
    acceleration_predicted: Array
    clock_offset: float
    """Robot time when the IMU's clock shows 0 [s], estimated or given."""

    @property
    def angular_velocity_error(self) -> Array:
        """Measured minus predicted."""
        return self.angular_velocity_measured - self.angular_velocity_predicted

    @property
    def acceleration_error(self) -> Array:
        """Measured minus predicted."""
        return self.acceleration_measured - self.acceleration_predicted


def compare(
    samples: ImuSamples,
    time: Array,
    motor_angle: Array,
    robot: kinematics.Robot,
    cfg: ProcessingCfg | None = None,
    *,
    offset: float | None = None,
    gravity: Array = compensation.GRAVITY,
) -> ImuComparison:
    """Compare IMU samples with the motion that logged motor angles predict.

    Args:
        samples: by the IMU's clock.
        time: (N,) [s], instants of the log by the robot's clock.
        motor_angle: (N, n) [rad], arm side.
        robot: D-H description down to the IMU, e.g. `armside.kinematics.IRB1400_IMU`.
        offset: clock offset [s], if known; otherwise it is estimated from the gyro.
        gravity: (3,) [m/s^2], specific force at rest in base axes.
    """
    cfg = cfg or ProcessingCfg()
    if offset is None:
        offset = find_offset(samples, time, motor_angle, robot, cfg)
    robot_time = samples.time + offset
    inside = (robot_time >= time[0]) & (robot_time <= time[-1])
    period = 1.0 / rate_of(samples.time)
    low_pass = ZeroPhaseButterworth(cfg.cutoff, period)

    def predicted(delay: float, order: Order, scheme: Scheme) -> PredictedMotion:
        phi = resample(time, motor_angle, robot_time[inside] - delay)
        return predict(robot, phi, period, low_pass, order=order, scheme=scheme)

    delays = cfg.accelerometer_delay, cfg.gyroscope_delay
    at_force, at_rate = (predicted(delay, cfg.order, cfg.scheme) for delay in delays)
    force, rate = samples.acceleration[inside], samples.angular_velocity[inside]
    if cfg.compensation is Compensation.ACTUAL_ORIENTATION:
        # Forward differences are half a sample early: a fit would mistake that for a tilt.
        linear, angular = (predicted(d, Order.MAP_THEN_FILTER, Scheme.CENTRAL) for d in delays)
        total = linear.acceleration + gravity
        ideal_force = compensation.to_imu(linear.R_base_imu, total)
        ideal_rate = compensation.to_imu(angular.R_base_imu, angular.angular_velocity)
        fitted = compensation.calibrate(force, rate, ideal_force, ideal_rate)
        force, rate = fitted.corrected(force, rate)
    a = compensation.to_base(at_force.R_base_imu, force) - gravity
    omega = compensation.to_base(at_rate.R_base_imu, rate)
    if cfg.compensation is Compensation.MEAN_AT_REST:
        rest = _first_rest(at_force, transient=round(1.0 / (cfg.cutoff * period)))
        a, omega = compensation.mean_removed(a, rest), compensation.mean_removed(omega, rest)
    rates = low_pass(omega), at_rate.angular_velocity
    forces = low_pass(a), at_force.acceleration
    return ImuComparison(robot_time[inside], *rates, *forces, offset)


def find_offset(
    samples: ImuSamples,
    time: Array,
    motor_angle: Array,
    robot: kinematics.Robot,
    cfg: ProcessingCfg,
) -> float:
    """Clock offset [s], from the rotation in both gyro samples and motor angles."""
    period = 1.0 / rate_of(time)
    low_pass = ZeroPhaseButterworth(SYNC_CUTOFF, period)
    predicted = predict(robot, motor_angle, period, low_pass, scheme=Scheme.CENTRAL)
    body_rate = compensation.to_imu(predicted.R_base_imu, predicted.angular_velocity)
    gyro, delay = samples.angular_velocity, cfg.gyroscope_delay
    return clock_offset(samples.time, gyro, time, body_rate, search=cfg.search, gyro_delay=delay)


def _first_rest(prediction: PredictedMotion, transient: int) -> NDArray[np.bool_]:
    """Samples before the first motion, (K,), without the transient of the low-pass at the start."""
    rate, acceleration = np.abs(prediction.angular_velocity), np.abs(prediction.acceleration)
    moving = np.hstack((rate > REST_RATE, acceleration > REST_ACCELERATION)).any(axis=1)
    later = np.arange(len(rate)) >= transient
    return later & ~np.logical_or.accumulate(moving & later)


def moving_rms(error: Array, window: float, period: float) -> Array:
    """Moving RMS of (K, n) over a centred window [s], shorter at the ends. Thesis Fig. 5.10."""
    half = max(1, round(window / period / 2))
    total = np.concatenate([np.zeros((1, error.shape[1])), np.cumsum(error**2, axis=0)])
    index = np.arange(len(error))
    first, last = np.maximum(index - half, 0), np.minimum(index + half + 1, len(error))
    return np.sqrt((total[last] - total[first]) / (last - first)[:, np.newaxis])
