"""Covariance of the tool's estimated displacement: filter, springs, encoders and gear errors.

    P(t) = T P_filter(t) T^T + S(t) cov(theta) S(t)^T + J (E + diag v(t)) J^T

The filter counts what disturbs a known arm whose motor angles are exact. S are sensitivities of the
estimate to the identified parameters theta, E is the variance of an encoder's counts and v that of
gear errors whose phases nobody knows. Lost motion, and what one linear arm cannot be, are not
counted.
"""

from collections.abc import Callable

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.prediction_error import ParameterEstimate

from ..instruments.encoder import resolution
from ..robot.drives import EXACT, Drives
from ..robot.effects import Effect, available, gear_orders
from ..robot.model import RobotModel
from .arm_estimator import ArmEstimator
from .arm_identification import Run
from .observer import ENCODER_FILTER

STEP = 0.1
"""Of the differences for sensitivities, over a parameter's standard deviation."""


def tool_covariance(
    known: ArmEstimator,
    run: Run,
    fit: ParameterEstimate,
    path: Callable[[Array], Array],
    robot: RobotModel,
) -> Array:
    """(K, 3, 3) [m^2] of the smoothed displacement from rest, at the IMU's instants.

    Args:
        path: tool path (K, 3) [m] at those instants, estimated with the parameters theta (m,).
        robot: data of the robot's type: its encoders, and the amplitudes of its gear errors.
    """
    T = known.model.tool[:3]
    S = sensitivities(path, fit)
    P = T @ known.smoother(run).smoothed_covariance @ T.T
    P = P + S @ fit.covariance @ np.swapaxes(S, 1, 2)
    variance = np.zeros((len(run.imu_time), robot.n_axes))
    variance += encoder_variance(robot.drives, run.period)
    if known.arm.gear_error is EXACT and Effect.GEAR_ERROR in available(robot):
        at = np.searchsorted(run.time, run.imu_time + known.clock_offset)
        variance += gear_variance(robot, run.phi[np.minimum(at, len(run.phi) - 1)])
    J = T[:, known.model.arm.axes]
    return np.asarray(P + (J * variance[:, None, :]) @ J.T, dtype=np.float64)


def sensitivities(path: Callable[[Array], Array], fit: ParameterEstimate) -> Array:
    """(K, 3, m) of a path (K, 3) [m] to the parameters of a fit."""
    here, steps = path(fit.theta), STEP * fit.standard_deviation
    moved = [path(fit.theta + step) - here for step in np.diag(steps)]
    return np.stack(moved, axis=2) / steps


def encoder_variance(drives: Drives, period: float) -> Array:
    """(n,) [rad^2] of the gears' outputs from rest, by rounding to counts and encoder noise.

    Rounding is white along a motion, and one constant error at rest; the low-pass of motor angles
    leaves the fraction 2 f T of what is white.
    """
    if not drives.encoder_counts > 0.0:
        return np.zeros(len(drives.gear))
    left = min(2.0 * ENCODER_FILTER * period, 1.0)
    count = resolution(drives.encoder_counts, drives.gear) ** 2
    return count * ((1.0 + left) / 12.0 + left * drives.encoder_noise**2)


def gear_variance(robot: RobotModel, turned: Array) -> Array:
    """(N, n) [rad^2] of gear errors of unknown phase, for motor angles (N, n) [rad] from rest."""
    amplitude, order = gear_orders(robot)
    error = amplitude**2 * (1.0 - np.cos(turned[:, :, None] * order))
    return np.asarray(error.sum(axis=2), dtype=np.float64)
