"""Clock offset between IMU and robot, estimated from a rotation that both recorded."""

from collections.abc import Callable

import numpy as np

from armside.arrays import Array

from .compensation import cross_matrices

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
    cost = [np.sum(_centred(gyro - at(tau)) ** 2) for tau in grid]
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
        score = np.einsum("kia,ki->a", J, _centred(gyro - omega))
        tau += float(np.linalg.solve(information, score)[0])
    return tau


def _centred(x: Array) -> Array:
    return x - x.mean(axis=0)
