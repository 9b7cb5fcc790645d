"""Errors of an IMU that look like motion: clock, bias, mounting, scale and misalignment."""

import numpy as np
from scipy.optimize import OptimizeResult, minimize_scalar

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..instruments.imu import ImuCfg, TriadCfg

_FREE = 1e3
"""Standard deviation of bias and its drift [m/s^2] or [rad/s]: nothing is known of them."""
_EXACT = 1e-9
"""Standard deviation of what a data sheet says to be exact."""
_SYNCHRONISED = 3.0
"""[Hz], below which readings are compared for the clock's offset: springs hardly delay them."""


def clock_offset(
    unit_time: Array, reading: Array, time: Array, expected: Array, largest: float
) -> float:
    """Robot time less unit time [s], by least squares of readings (K, 3) on expected ones (N, 3).

    An affine map of the expected readings stands for bias, mounting and scale. `largest`: of the
    offset [s]; twice that is searched.
    """
    period = float(unit_time[1] - unit_time[0])
    smooth = ZeroPhaseButterworth(_SYNCHRONISED, period)(reading)
    expected = ZeroPhaseButterworth(_SYNCHRONISED, float(time[1] - time[0]))(expected)

    def misfit(offset: float) -> float:
        moved = [np.interp(unit_time + offset, time, column) for column in expected.T]
        A = np.column_stack((*moved, np.ones(len(unit_time))))
        left = smooth - A @ np.linalg.lstsq(A, smooth, rcond=None)[0]
        return float(np.sum(left**2))

    bound = 2.0 * largest + period
    found = minimize_scalar(misfit, bounds=(-bound, bound), method="bounded")
    assert isinstance(found, OptimizeResult)
    return float(found.x)


def unit_errors(time: Array, reading: Array, cfg: ImuCfg, triad: TriadCfg) -> tuple[Array, Array]:
    """Columns (K, 3, 19) of the errors of a triad, and their standard deviations (19,).

    Bias and its drift, mounting, scale and misalignment, clock. reading: (K, 3) of a perfect unit.
    """
    n, unit = len(reading), np.eye(3)
    ramp = np.linspace(-1.0, 1.0, n)
    bias = np.concatenate((np.tile(unit, (n, 1, 1)), ramp[:, None, None] * unit), axis=2)
    mounting = np.stack([np.cross(reading, axis) for axis in unit], axis=2)
    sensitivity = (unit[None, :, :, None] * reading[:, None, None, :]).reshape(n, 3, 9)
    clock = np.gradient(reading, time, axis=0)[:, :, None]
    errors = np.where(unit > 0.0, triad.scale_error, triad.misalignment).ravel()
    known = np.concatenate((np.full(3, cfg.mounting_error), errors))
    deviation = np.concatenate(
        (np.full(6, _FREE), np.maximum(known, _EXACT), [max(cfg.clock_offset, _EXACT)])
    )
    return np.concatenate((bias, mounting, sensitivity, clock), axis=2), deviation
