"""Residual of each commissioning cut by a twin that was identified without it.

A cut is left out of the normal equations of the last step, so no further simulation is needed.
"""

from collections.abc import Sequence

import numpy as np

from armside.arrays import Array

from .normal_equations import Solving, grouped
from .sensitivities import Columns, Residuals


def held_out(
    solving: Solving, residuals: Sequence[Residuals], columns: Sequence[Columns]
) -> tuple[Array, Array]:
    """Root mean square of the tool's residual [m] of each cut, left out and included: (c,), (c,).

    A single cut cannot be left out: NaN.
    """
    every = range(len(residuals))
    whole = solving.solve(grouped(residuals, columns)).change
    without = [
        _tool_residual(residuals[i], columns[i], _left_out(solving, residuals, columns, i))
        for i in every
    ]
    within = [_tool_residual(residuals[i], columns[i], whole) for i in every]
    return np.array(without), np.array(within)


def _left_out(
    solving: Solving, residuals: Sequence[Residuals], columns: Sequence[Columns], i: int
) -> Array:
    others = [j for j in range(len(residuals)) if j != i]
    if not others:
        return np.full(solving.parameters.size, np.nan)
    return solving.solve(
        grouped([residuals[j] for j in others], [columns[j] for j in others])
    ).change


def _tool_residual(residual: Residuals, columns: Columns, change: Array) -> float:
    left = residual.tool - columns.tool @ change
    return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))
