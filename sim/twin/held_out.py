"""Residual of each commissioning cut by a twin that was identified without it.

A cut is left out of the normal equations of the last step, so no further simulation is needed.
"""

from collections.abc import Sequence

import numpy as np

from armside.arrays import Array

from .normal_equations import Compared, Solving, together


def held_out(solving: Solving, cuts: Sequence[Compared]) -> tuple[Array, Array]:
    """Root mean square of the tool's residual of each cut, left out and included: (c,), (c,).

    In the unit of the sensor. A single cut cannot be left out: NaN.
    """
    whole = solving.solve(together(cuts)).change
    without = [_tool_residual(cut, _left_out(solving, cuts, cut)) for cut in cuts]
    within = [_tool_residual(cut, whole) for cut in cuts]
    return np.array(without), np.array(within)


def _left_out(solving: Solving, cuts: Sequence[Compared], cut: Compared) -> Array:
    others = [other for other in cuts if other is not cut]
    if not others:
        return np.full(solving.parameters.size, np.nan)
    return solving.solve(together(others)).change


def _tool_residual(cut: Compared, change: Array) -> float:
    left = cut.residuals.tool - cut.columns.tool @ change
    return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))
