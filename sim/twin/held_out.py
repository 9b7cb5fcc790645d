"""Residual of each commissioning cut by a twin that was identified without it.

A cut is left out of the normal equations of the last step, so no further simulation is needed.
"""

from collections.abc import Sequence

import numpy as np

from armside.arrays import Array

from .normal_equations import Solving, grouped
from .sensitivities import Columns, Residuals
from .tool_sensor import Channels


def held_out(
    solving: Solving,
    residuals: Sequence[Residuals],
    columns: Sequence[Columns],
    channels: Sequence[Channels],
) -> tuple[Array, Array]:
    """Root mean square of the tool's residual of each cut, left out and included: (c,), (c,).

    In the unit of the sensor. A single cut cannot be left out: NaN.
    """
    every = range(len(residuals))
    whole = solving.solve(grouped(residuals, columns, channels)).change
    without = [
        _tool_residual(
            residuals[i], columns[i], _left_out(solving, residuals, columns, channels, i)
        )
        for i in every
    ]
    within = [_tool_residual(residuals[i], columns[i], whole) for i in every]
    return np.array(without), np.array(within)


def _left_out(
    solving: Solving,
    residuals: Sequence[Residuals],
    columns: Sequence[Columns],
    channels: Sequence[Channels],
    i: int,
) -> Array:
    others = [j for j in range(len(residuals)) if j != i]
    if not others:
        return np.full(solving.parameters.size, np.nan)
    return solving.solve(
        grouped([residuals[j] for j in others], [columns[j] for j in others], channels)
    ).change


def _tool_residual(residual: Residuals, columns: Columns, change: Array) -> float:
    left = residual.tool - columns.tool @ change
    return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))
