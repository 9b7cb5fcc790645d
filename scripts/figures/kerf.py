"""`kerf.png`: the sheet after the cut, and the hole's edge over the arc length."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from armside.arrays import Array
from armside.sim.evaluation.kerf import Kerf

from .laser import COLORS, REFERENCE, new_figure, save

SHEET, PIECE, GAP = "#E3E3E3", "#F6F6F6", "#333333"
MARGIN = 1.12
WIDTH, STRIP = 9.6, 2.2
"""Width of the figure and height of the plot of the edge [inch]."""
TICK = 0.22
"""Least distance of numbers at the y-axis of a panel [inch]."""


def kerf(file: Path, cuts: Sequence[tuple[int, Kerf]], measure: str = "roundness") -> None:
    """Sheet after each cut, a panel per cut, to scale; below, the edges over the arc length.

    cuts: iteration and edges, all of the same points of one contour and of one beam.
    measure: name of the width of the edge's band. Points that are not finite leave a gap.
    """
    arc_length, beam = cuts[0][1].arc_length, cuts[0][1].beam
    programmed = cuts[0][1].curve.point(arc_length)
    edges = np.concatenate([cut.edge(cut.outer) for _, cut in cuts] + [programmed])
    reach = MARGIN * 1e3 * np.nanmax(np.abs(np.where(np.isfinite(edges), edges, np.nan)), axis=0)
    columns = max(2, len(cuts))
    panel = (WIDTH * 0.92 / columns - 0.4) * reach[1] / reach[0]
    height = panel + STRIP + 1.9
    figure = new_figure(WIDTH, height)
    grid = figure.add_gridspec(2, columns, height_ratios=(panel, STRIP))
    grid.update(left=0.08, right=0.985, hspace=1.5 / (panel + STRIP))
    grid.update(bottom=0.55 / height, top=1.0 - 0.6 / height)
    title = f"Cut with a beam of {beam * 1e3:g} mm, true to scale"
    figure.suptitle(title, x=0.02, y=1.0 - 0.15 / height, ha="left", va="top")
    at = {"loc": "upper right", "bbox_to_anchor": (0.99, 1.0 - 0.08 / height)}
    figure.legend(handles=_legend(), frameon=False, ncols=4, fontsize=8, **at)
    for column, (k, cut) in enumerate(cuts):
        axes = figure.add_subplot(grid[0, column])
        _sheet(axes, programmed, cut)
        axes.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]), aspect="equal")
        axes.set_title(f"k = {k}    {measure} {cut.roundness * 1e6:.0f} µm", fontsize=9)
        axes.set(xlabel="x [mm]", ylabel="y [mm]" if column == 0 else "")
        axes.yaxis.set_major_locator(MaxNLocator(nbins=max(1, int(panel / TICK)), min_n_ticks=1))
    edge_axes = figure.add_subplot(grid[1, :])
    for (k, cut), color in zip(cuts, (COLORS[1], COLORS[0], *COLORS[2:]), strict=False):
        style = {"color": color, "lw": 1.3, "label": f"k = {k}"}
        edge_axes.plot(arc_length * 1e3, cut.hole_deviation * 1e6, **style)
    edge_axes.axhline(0.0, color=REFERENCE, lw=1.0)
    edge_axes.set_title("Edge of the hole over the arc length", loc="left", fontsize=10)
    edge_axes.set(xlabel="arc length [mm]", ylabel="deviation outwards [µm]")
    edge_axes.set_xlim(0.0, float(arc_length[-1]) * 1e3)
    edge_axes.grid(True, color="#DDDDDD", lw=0.6)
    place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
    edge_axes.legend(frameon=False, ncols=len(cuts), fontsize=8, **place)
    save(figure, file)


def _legend() -> list[Artist]:
    fills = (("sheet", SHEET), ("kerf", GAP), ("cut out", PIECE))
    patches = [Patch(facecolor=color, edgecolor=REFERENCE, label=name) for name, color in fills]
    return [*patches, Line2D([], [], color=COLORS[4], lw=0.8, ls=(0, (4, 3)), label="programmed")]


def _sheet(axes: Axes, programmed: Array, cut: Kerf) -> None:
    """Draw the sheet, the kerf and the piece within it."""
    axes.set_facecolor(SHEET)
    for offset, color in ((cut.outer, GAP), (cut.inner, PIECE)):
        edge = cut.edge(offset)
        whole = edge[np.isfinite(edge).all(axis=1)] * 1e3
        axes.fill(*whole.T, color=color, lw=0.0)
    closed = np.vstack([programmed, programmed[:1]]) * 1e3
    axes.plot(*closed.T, color=COLORS[4], lw=0.8, ls=(0, (4, 3)))
