"""Panels and tables of the figures of chapter 8."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from armside.ilc.models.two_mass import TwoMassLoop
from armside.ilc.two_mass_study import Study

from .laser import COLORS, new_figure, save

LOOP = TwoMassLoop()
"""Joint and controller of the thesis."""
THESIS = Study()
"""Joint and design of the thesis."""


def panels(width: float, height: float, rows: int = 1, columns: int = 1, **shared: Any) -> Any:
    """Axes of a new figure of this size [inch], row by row: curves take the colours in turn."""
    grid = new_figure(width, height).subplots(rows, columns, squeeze=False, **shared).ravel()
    for axes in grid:
        axes.set_prop_cycle(color=COLORS)
    return grid


def finish(
    file: Path,
    grid: Sequence[Axes],
    xlabel: str,
    ylabel: str = "",
    *,
    titles: Sequence[str] = (),
    legends: Sequence[int] = (),
) -> None:
    """Label the panels and write the figure; legends: indices of the panels that have one."""
    for axes, title in zip(grid, titles, strict=False):
        axes.set_title(title, loc="left")
    grid[0].set_ylabel(ylabel)
    for i in legends:
        grid[i].legend(frameon=False)
    for axes in grid:
        axes.grid(True, which="major", color="#DDDDDD", lw=0.6)
        if axes.get_subplotspec().is_last_row():  # type: ignore[union-attr]
            axes.set_xlabel(xlabel)
    figure = grid[0].figure
    figure.set_layout_engine("constrained")  # type: ignore[union-attr]
    save(figure, file)  # type: ignore[arg-type]


def decibel(value: Any) -> Any:
    """20 log10 |value|."""
    return 20.0 * np.log10(np.abs(value))
