"""Measured against predicted motion of the IMU: the whole of thesis 5.1 as one function."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from armside import kinematics
from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..instruments.imu import ACCELEROMETER, GYROSCOPE, ImuSamples
from ..instruments.sampling import rate_of
from . import compensation
from .differences import Scheme, resample
from .prediction import Order, Prediction, predict
from .synchronise import clock_offset

SYNC_CUTOFF = 40.0
"""Smooths the encoder's steps before the clocks are compared, above the motion's content [Hz]."""
REST_RATE = 0.005
"""A sensor that turns and a tool that accelerates less than this is at rest [rad/s]."""
REST_ACCELERATION = 0.2
"""[m/s^2]; above what encoder noise predicts at rest."""


class Compensation(Enum):
    """What is done about gravity and offsets."""

    MEAN_AT_REST = "mean-at-rest"
    """Gravity in base axes and the mean in the zero pose are taken off. Thesis 5.1.1."""
    ACTUAL_ORIENTATION = "actual-orientation"
    """Mounting error and biases are fitted with the orientation of every sample, which the thesis
    names as future work."""


@dataclass(frozen=True, kw_only=True)
class ProcessingCfg:
    """How measurement and prediction are made comparable."""

    cutoff: float = 5.0
    """Of the zero-phase second-order low-pass [Hz]. Thesis 5.1.1."""
    order: Order = Order.FILTER_THEN_MAP
    scheme: Scheme = Scheme.FORWARD
    compensation: Compensation = Compensation.ACTUAL_ORIENTATION
    accelerometer_delay: float = ACCELEROMETER.delay
    """Known delay of the sensor's own low-pass [s]; 0 leaves it in."""
    gyroscope_delay: float = GYROSCOPE.delay
    """[s]."""
    search: float = 0.5
    """Largest clock offset looked for [s]."""


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Angular velocity and acceleration of the IMU in base axes, filtered alike."""

    time: Array
    """(K,) [s], robot time of the IMU samples."""
    angular_velocity_measured: Array
    """(K, 3) [rad/s]."""
    angular_velocity_predicted: Array
    """(K, 3) [rad/s]."""
    acceleration_measured: Array
    """(K, 3) [m/s^2], without gravity."""
    acceleration_predicted: Array
    """(K, 3) [m/s^2]."""
    clock_offset: float
    """Found or given [s]."""

    @property
    def angular_velocity_error(self) -> Array:
        """Measured less predicted, (K, 3) [rad/s]."""
        return self.angular_velocity_measured - self.angular_velocity_predicted

    @property
    def acceleration_error(self) -> Array:
        """Measured less predicted, (K, 3) [m/s^2]."""
        return self.acceleration_measured - self.acceleration_predicted


def compare(
    samples: ImuSamples,
    time: Array,
    motor_angle: Array,
    robot: kinematics.Robot,
    cfg: ProcessingCfg | None = None,
    *,
    offset: float | None = None,
) -> Comparison:
    """Bring IMU samples and logged motor angles together.

    Args:
        samples: by the IMU's clock.
        time: (N,) [s], of the log, by the robot's clock.
        motor_angle: (N, n) [rad], arm side.
        robot: D-H description down to the IMU, e.g. `armside.kinematics.IRB1400_IMU`.
        offset: of the IMU's clock [s], if it is known; otherwise it is found from the gyro.
    """
    cfg = cfg or ProcessingCfg()
    if offset is None:
        offset = find_offset(samples, time, motor_angle, robot, cfg)
    robot_time = samples.time + offset
    inside = (robot_time >= time[0]) & (robot_time <= time[-1])
    period = 1.0 / rate_of(samples.time)
    low_pass = ZeroPhaseButterworth(cfg.cutoff, period)

    def predicted(delay: float, order: Order, scheme: Scheme) -> Prediction:
        phi = resample(time, motor_angle, robot_time[inside] - delay)
        return predict(robot, phi, period, low_pass, order=order, scheme=scheme)

    delays = cfg.accelerometer_delay, cfg.gyroscope_delay
    at_force, at_rate = (predicted(delay, cfg.order, cfg.scheme) for delay in delays)
    force, rate = samples.acceleration[inside], samples.angular_velocity[inside]
    if cfg.compensation is Compensation.ACTUAL_ORIENTATION:
        # Forward differences are half a sample early: a fit would take that for a tilt.
        best = [predicted(delay, Order.MAP_THEN_FILTER, Scheme.CENTRAL) for delay in delays]
        force, rate = _calibrated(force, rate, *best)
    a = compensation.to_base(at_force.R_base_imu, force) - compensation.GRAVITY
    omega = compensation.to_base(at_rate.R_base_imu, rate)
    if cfg.compensation is Compensation.MEAN_AT_REST:
        rest = _first_rest(at_force, settled=round(1.0 / (cfg.cutoff * period)))
        a, omega = compensation.mean_removed(a, rest), compensation.mean_removed(omega, rest)
    return Comparison(
        time=robot_time[inside],
        angular_velocity_measured=low_pass(omega),
        angular_velocity_predicted=at_rate.angular_velocity,
        acceleration_measured=low_pass(a),
        acceleration_predicted=at_force.acceleration,
        clock_offset=offset,
    )


def find_offset(
    samples: ImuSamples,
    time: Array,
    motor_angle: Array,
    robot: kinematics.Robot,
    cfg: ProcessingCfg,
) -> float:
    """Of the IMU's clock [s], from the rotation that gyro and motor angles share."""
    period = 1.0 / rate_of(time)
    low_pass = ZeroPhaseButterworth(SYNC_CUTOFF, period)
    seen = predict(robot, motor_angle, period, low_pass, scheme=Scheme.CENTRAL)
    body_rate = compensation.to_imu(seen.R_base_imu, seen.angular_velocity)
    return clock_offset(
        samples.time,
        samples.angular_velocity,
        time,
        body_rate,
        search=cfg.search,
        gyro_delay=cfg.gyroscope_delay,
    )


def _first_rest(prediction: Prediction, settled: int) -> NDArray[np.bool_]:
    """The samples before the first motion, less the first ones: there the low-pass takes a step of
    the encoder for more."""
    rate, acceleration = np.abs(prediction.angular_velocity), np.abs(prediction.acceleration)
    moving = np.hstack((rate > REST_RATE, acceleration > REST_ACCELERATION)).any(axis=1)
    later = np.arange(len(rate)) >= settled
    return later & ~np.logical_or.accumulate(moving & later)


def _calibrated(
    force: Array, rate: Array, at_force: Prediction, at_rate: Prediction
) -> tuple[Array, Array]:
    """Readings without the mounting error and biases that a fit over the whole record finds."""
    total = at_force.acceleration + compensation.GRAVITY
    calibration = compensation.calibrate(
        force,
        rate,
        compensation.to_imu(at_force.R_base_imu, total),
        compensation.to_imu(at_rate.R_base_imu, at_rate.angular_velocity),
    )
    return calibration.corrected(force, rate)


def moving_rms(error: Array, window: float, period: float) -> Array:
    """RMS of (K, n) over a centred window [s], shorter at the ends. Thesis Fig. 5.10."""
    half = max(1, round(window / period / 2))
    total = np.concatenate([np.zeros((1, error.shape[1])), np.cumsum(error**2, axis=0)])
    index = np.arange(len(error))
    first, last = np.maximum(index - half, 0), np.minimum(index + half + 1, len(error))
    return np.sqrt((total[last] - total[first]) / (last - first)[:, np.newaxis])
