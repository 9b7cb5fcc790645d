"""`kerf.png`: the sheet after the cut, and the hole's edge rolled out; from arrays alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from armside.arrays import Array

from .laser import COLORS, INK, REFERENCE, new_figure, save

SHEET, PIECE, GAP = "#E3E3E3", "#F6F6F6", "#333333"
MARGIN = 1.12
WIDTH, STRIP = 9.6, 2.2
"""[inch], of the figure, and height of the edge rolled out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Cut:
    """One cut to be drawn."""

    k: int
    """Iteration."""
    outer: Array
    """(M, 2) [m], edge of the hole."""
    inner: Array
    """(M, 2) [m], edge of the piece that falls out."""
    deviation: Array
    """(M,) [m], of the hole's edge from the programmed one."""
    roundness: float
    """[m]."""


def kerf(
    file: Path,
    programmed: Array,
    way: Array,
    cuts: Sequence[Cut],
    *,
    beam: float,
    measure: str = "roundness",
) -> None:
    """The sheet as it is cut, a panel per cut, to scale; below, the edges of the holes rolled out.

    programmed: (M, 2) [m], contour of the beam's centre. way: (M,) [m], along it.
    beam: its diameter [m]. measure: what the width of the edge's band is called.
    Points that are not finite leave a gap.
    """
    edges = np.concatenate([cut.outer for cut in cuts] + [programmed])
    reach = MARGIN * 1e3 * np.nanmax(np.abs(np.where(np.isfinite(edges), edges, np.nan)), axis=0)
    columns = max(2, len(cuts))
    panel = (WIDTH * 0.92 / columns - 0.4) * reach[1] / reach[0]
    height = panel + STRIP + 1.9
    figure = new_figure(WIDTH, height)
    grid = figure.add_gridspec(
        2,
        columns,
        height_ratios=(panel, STRIP),
        left=0.08,
        right=0.985,
        bottom=0.55 / height,
        top=1.0 - 0.6 / height,
        hspace=1.5 / (panel + STRIP),
    )
    figure.suptitle(
        f"Cut with a beam of {beam * 1e3:g} mm, true to scale",
        x=0.02,
        y=1.0 - 0.15 / height,
        ha="left",
        va="top",
    )
    for column, cut in enumerate(cuts):
        axes = figure.add_subplot(grid[0, column])
        _sheet(axes, programmed, cut)
        axes.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]), aspect="equal")
        axes.set_title(f"k = {cut.k}    {measure} {cut.roundness * 1e6:.0f} µm", fontsize=9)
        axes.set_xlabel("x [mm]")
        axes.set_ylabel("y [mm]" if column == 0 else "")
    rolled_out = figure.add_subplot(grid[1, :])
    for cut, color in zip(cuts, (COLORS[1], COLORS[0], *COLORS[2:]), strict=False):
        label = f"k = {cut.k}"
        rolled_out.plot(way * 1e3, cut.deviation * 1e6, color=color, lw=1.3, label=label)
    rolled_out.axhline(0.0, color=REFERENCE, lw=1.0)
    rolled_out.set_title("Edge of the hole, rolled out", loc="left", fontsize=10)
    rolled_out.set_xlabel("way along the contour [mm]")
    rolled_out.set_ylabel("outwards of programmed [µm]")
    rolled_out.set_xlim(0.0, float(way[-1]) * 1e3)
    rolled_out.grid(True, color="#DDDDDD", lw=0.6)
    rolled_out.legend(
        frameon=False, ncols=len(cuts), fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0)
    )
    save(figure, file)


def _sheet(axes: Axes, programmed: Array, cut: Cut) -> None:
    """Sheet, the gap that the beam left, and the piece within it."""
    axes.set_facecolor(SHEET)
    for edge, color in ((cut.outer, GAP), (cut.inner, PIECE)):
        whole = edge[np.isfinite(edge).all(axis=1)] * 1e3
        axes.fill(*whole.T, color=color, lw=0.0)
    closed = np.vstack([programmed, programmed[:1]]) * 1e3
    axes.plot(*closed.T, color=COLORS[4], lw=0.8, ls=(0, (4, 3)))
    axes.text(0.5, 0.5, "falls out", transform=axes.transAxes, ha="center", color=INK, fontsize=8)
    axes.text(0.02, 0.02, "sheet", transform=axes.transAxes, color=INK, fontsize=8)
