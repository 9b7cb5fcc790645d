"""Offset of an IMU's clock from the robot's, by the motion that both have seen."""

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

_SYNCHRONISED = 3.0
"""[Hz], below which readings are compared: springs hardly delay them."""


def clock_offset(
    unit_time: Array, reading: Array, expected: Array, step: float, largest: float
) -> float:
    """Robot time less unit time [s], by least squares of readings (K, 3) on expected ones (N, 3).

    An affine map of the expected readings stands for bias, mounting and scale. `step`: between
    expected readings [s], which start at robot time 0. `largest`: of the offset [s]; twice that is
    searched.
    """
    from scipy.optimize import OptimizeResult, minimize_scalar

    period = float(unit_time[1] - unit_time[0])
    smooth = ZeroPhaseButterworth(_SYNCHRONISED, period)(reading)
    expected = ZeroPhaseButterworth(_SYNCHRONISED, step)(expected)
    time = np.arange(len(expected)) * step

    def misfit(offset: float) -> float:
        moved = [np.interp(unit_time + offset, time, column) for column in expected.T]
        A = np.column_stack((*moved, np.ones(len(unit_time))))
        left = smooth - A @ np.linalg.lstsq(A, smooth, rcond=None)[0]
        return float(np.sum(left**2))

    bound = 2.0 * largest + period
    found = minimize_scalar(misfit, bounds=(-bound, bound), method="bounded")
    assert isinstance(found, OptimizeResult)
    return float(found.x)
