"""Where a speed profile is slower than any limit asks for."""

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from .profile_grid import Grid

SLACK = 0.5
"""Fraction of the lowest speed allowed within reach of a place that it need not fall below."""
STANDSTILL = 0.01
"""Fraction of a path's highest speed that counts as rest."""


def resting(grid: Grid, x: Array, slack: float) -> NDArray[np.bool_]:
    """(N,), points of a grid whose speed is below `slack` of one that could be held there.

    The lowest speed allowed within the length of a ramp to the highest can be held over all of it;
    the ramps at both ends are left out. x: (N,) [m^2/s^2].
    """
    from scipy.ndimage import minimum_filter1d

    allowed = grid.caps
    if grid.joints is not None:
        allowed = np.minimum(allowed, grid.joints.steady)
    reach = int(grid.limits.ramp_length(float(grid.caps.max())) / grid.step) + 1
    lowest = minimum_filter1d(allowed, 2 * reach + 1)
    peak = np.minimum(grid.limits.acceleration, np.sqrt(grid.limits.jerk * lowest))
    ramp = 0.5 * lowest * (lowest / np.maximum(peak, 1e-12) + peak / grid.limits.jerk)
    from_end = np.minimum(grid.s, grid.ends[-1] - grid.s)
    return (np.sqrt(x) < slack * lowest) & (from_end > 2.0 * ramp) & ~grid.held
