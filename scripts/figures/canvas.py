"""Colours, panels and files of all figures: same arrays, same bytes.

Colours are those of Okabe and Ito, which stay apart in colour-blind eyes; markers differ too.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler
from matplotlib.ticker import LogLocator, MaxNLocator, StrMethodFormatter

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = ("o", "s", "^", "D", "v", "P")
INK = "#333333"
REFERENCE = "#9A9A9A"
STYLE: dict[Any, Any] = {
    "axes.prop_cycle": cycler(color=COLORS),
    "axes.titlelocation": "left",
    "axes.titlesize": 9,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
}
LARGE: dict[Any, Any] = {"axes.titlesize": 12, "legend.fontsize": 10}


@contextmanager
def panels(
    file: Path,
    size: tuple[float, float],
    rows: int = 1,
    columns: int = 1,
    *,
    title: str = "",
    titles: Sequence[str] = (),
    labels: tuple[str, str] = ("", ""),
    legends: Sequence[int] = (),
    edges: Sequence[float] | None = None,
    gaps: tuple[float | None, float | None] = (None, None),
    large: bool = False,
    ruled: bool = False,
    **shared: Any,
) -> Iterator[Any]:
    """Axes of a new figure, row by row, in our style; saved when the block ends well.

    Curves take the colours in turn. size: width and height [inch]. titles: of panels. labels: of
    the outer axes. legends: indices of panels that have one. edges: left, right, bottom, top, as
    fractions; None: found by matplotlib. gaps: between columns and rows, over the size of a panel.
    large: titles of panels and legends. ruled: with grid lines. shared: of `Figure.subplots`.
    """
    look: dict[Any, Any] = {**STYLE, **(LARGE if large else {}), "axes.grid": ruled}
    with mpl.rc_context(look):
        figure = new_figure(*size)
        if title:
            figure.suptitle(title, x=0.02, ha="left")
        grid = figure.subplots(rows, columns, squeeze=False, **shared)
        if edges is None:
            figure.set_layout_engine("constrained")
        else:
            sides = dict(zip(("left", "right", "bottom", "top"), edges, strict=True))
            figure.subplots_adjust(**sides, wspace=gaps[0], hspace=gaps[1])
        for axes in grid[-1]:
            axes.set_xlabel(labels[0])
        for axes in grid[:, 0]:
            axes.set_ylabel(labels[1])
        for axes, name in zip(grid.flat, titles, strict=False):
            axes.set_title(name)
        yield grid.ravel()
        for i in legends:
            grid.flat[i].legend()
        save(figure, file)


@contextmanager
def tiles(
    file: Path,
    n: int,
    columns: int,
    tile: tuple[float, float],
    *,
    edges: tuple[float, float, float, float],
    gaps: tuple[float, float],
    **shared: Any,
) -> Iterator[Any]:
    """As `panels`, for n panels of width and height `tile` in some columns, all in [inch].

    The sizes are given, as a layout engine would draw everything twice.
    """
    columns = min(columns, n)
    rows = -(-n // columns)
    (left, right, bottom, top), (gap_x, gap_y) = edges, gaps
    width = left + columns * tile[0] + (columns - 1) * gap_x + right
    height = bottom + rows * tile[1] + (rows - 1) * gap_y + top
    sides = left / width, 1.0 - right / width, bottom / height, 1.0 - top / height
    between, size = (gap_x / tile[0], gap_y / tile[1]), (width, height)
    with panels(file, size, rows, columns, edges=sides, gaps=between, **shared) as grid:
        yield grid[:n]
        for axes in grid[n:]:
            axes.set_visible(False)
        if "sharex" not in shared:  # the lowest of each column has the label
            for axes in grid[n - columns : n]:
                axes.set_xlabel(grid[-1].get_xlabel())


def new_figure(width: float, height: float) -> Figure:
    """Empty figure of width and height [inch], independent of matplotlib's global state."""
    figure = Figure(figsize=(width, height), dpi=120)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, file: Path) -> None:
    """Give all axes the common look and write a PNG that depends on the figure alone."""
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(which="both", colors=INK, labelsize=8)
    figure.savefig(file, metadata={"Software": None})


def whole_numbers(axis: Axis) -> None:
    """Ticks at integers alone, as iterations need them, also where one is all there is."""
    axis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def logarithmic(axes: Axes) -> None:
    """A logarithmic y axis with plain numbers at 1, 2 and 5."""
    axes.set_yscale("log")
    axes.yaxis.set_minor_locator(LogLocator(subs=(2, 5)))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(StrMethodFormatter("{x:g}"))


def magnification(at_most: float) -> float:
    """The largest of 1, 2, 5, 10, 20, ... that is not above `at_most`; at least 1."""
    most = max(at_most, 1.0) * (1.0 + 1e-9)  # or rounding could lose a power of ten
    decade = 10.0 ** np.floor(np.log10(most))
    return max(float(m * decade) for m in (1, 2, 5) if m * decade <= most)


def magnified(factor: float) -> str:
    """The magnification in words."""
    return f"magnified {factor:g} times" if factor > 1 else "to scale"
