"""Figures of a run as PNG files, from arrays alone."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from armside.arrays import Array
from armside.sim.evaluation.kerf import Kerf

from .canvas import (
    COLORS,
    INK,
    MARKERS,
    REFERENCE,
    logarithmic,
    magnification,
    magnified,
    new_figure,
    panels,
    save,
    tiles,
    whole_numbers,
)

SHOWN_DEVIATION = 0.6
"""Largest magnified deviation in `circles.png`, relative to half the shape's smaller side."""
FLATTEST = 0.25
"""Smallest height of a panel relative to its width."""
SIDE = 2.7
"""Width of a panel [inch], where there are three in a row."""
MOST_PANELS = 12
SCALE = 100
"""Deviation that the bar in `circles.png` is as long as [µm], less where that is too long."""
SHORT = 10
"""Letters of a panel's name that leave room for its numbers in the same line."""


def circles(
    file: Path,
    reference: Array,
    measured: Sequence[Array],
    *,
    rms: Sequence[float | None],
    maxdev: Sequence[float | None],
    title: str = "Tool path at every iteration",
    names: Sequence[str] | None = None,
    label: str = "measured",
) -> None:
    """Reference and measured path, a panel per iteration, deviations magnified. Thesis Fig 9.10.

    reference: (M, 2) closed path [m] in the plane of the shape, moved to the origin.
    measured: for each iteration k, (M_k, 2) [m], registered to the reference.
    rms, maxdev: for each iteration [m], written above its panel.
    names: of each measured path; k = 0, k = 1 ... if None.
    label: of the paths in the legend.
    All panels share one magnification, chosen from 1, 2, 5, 10, ... and stated in the figure. The
    axes hold for the reference; a bar gives the length of a deviation.
    Points that are not finite (a lost beam, a run that diverged) leave a gap.
    """
    measured = [np.where(np.isfinite(p).all(axis=1, keepdims=True), p, np.nan) for p in measured]
    foot = [_nearest(path, reference) for path in measured]
    half_width = 0.5 * float(np.ptp(reference, axis=0).min())
    worst = _largest([np.hypot(*(p - f).T) for p, f in zip(measured, foot, strict=True)])
    factor = magnification(SHOWN_DEVIATION * half_width / max(worst, 1e-12))

    drawn = [(f + factor * (p - f)) * 1e3 for p, f in zip(measured, foot, strict=True)]
    closed = np.vstack([reference, reference[:1]]) * 1e3
    reach = [1.06 * _largest([path[:, axis] for path in (closed, *drawn)]) for axis in (0, 1)]
    reach[0] = max(reach)  # panels are square, or wider than high
    if names is None:
        names = [f"k = {k}" for k in range(len(measured))]
    shown = _panels(len(measured))
    side = SIDE * max(1.0, min(2.0, 3 / len(shown)))  # room for the title above few panels
    long = max(map(len, names)) > SHORT
    between, extra = ("\n", 0.17) if long else ("    ", 0.0)  # a second line of the title [inch]
    tile = side, max(reach[1] / reach[0], FLATTEST) * side
    look = {"edges": (0.6, 0.1, 0.85, 0.7 + extra), "gaps": (0.35, 0.35 + extra)}
    shared: dict[str, Any] = {"labels": ("x [mm]", "y [mm]"), "sharex": True, "sharey": True}
    with tiles(file, len(shown), 3, tile, **look, **shared) as grid:
        figure = grid[0].figure
        heading = f"{title}, deviation {magnified(factor)}"
        figure.suptitle(heading, x=0.02, y=0.985, ha="left")
        for axes, k in zip(grid, shown, strict=True):
            axes.plot(*closed.T, color=REFERENCE, lw=1.0, label="reference")
            axes.plot(*drawn[k].T, color=COLORS[0], lw=1.2, label=f"{label}, {magnified(factor)}")
            axes.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]), aspect="equal")
            n_rows = max(1, round(7 * reach[1] / reach[0]))
            for axis, n in ((axes.xaxis, 7), (axes.yaxis, n_rows)):
                axis.set_major_locator(MaxNLocator(n, steps=[1, 2, 5, 10], min_n_ticks=1))
            numbers = f"RMS {_microns(rms[k])}, max {_microns(maxdev[k])}"
            axes.set_title(f"{names[k]}{between}{numbers}", loc="center")
        handles, labels = grid[0].get_legend_handles_labels()
        if factor > 1:
            bar = min(SCALE, magnification(5e5 * half_width / factor))
            at = 0.94 * reach[0] - np.array([1e-3 * factor * bar, 0.0])
            for axes in grid:
                handles[2:] = axes.plot(at, [-0.94 * reach[1]] * 2, color=INK, lw=3.0)
            labels.append(f"bar: deviation of {bar:g} µm")
        figure.legend(
            handles, labels, loc="lower center", ncols=3, fontsize=8 if len(shown) < 3 else 10
        )


def _microns(value: float | None) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value * 1e6:.0f} µm"


def errors(
    file: Path,
    motor: Array,
    arm_rms: Sequence[float | None],
    arm_maxdev: Sequence[float | None],
    *,
    motor_label: str = "motor error, 2-norm, normalised",
    ks: Sequence[int] | None = None,
) -> None:
    """Errors by iteration: the motors on the left, the tool on the right. Thesis Figs 9.9, 9.11.

    motor: (K, n) normalised motor errors. arm_rms, arm_maxdev: (K,) [m]. ks: (K,) iterations,
    0 .. K - 1 if None.
    """
    iterations = np.arange(len(motor)) if ks is None else np.array(ks)
    titles = "Motor side: what the robot sees", "Arm side: what the tool does"
    look = {"edges": (0.08, 0.985, 0.15, 0.91), "gaps": (0.24, None), "large": True, "ruled": True}
    labels = "iteration k", motor_label
    with panels(file, (9.6, 4.0), 1, 2, titles=titles, labels=labels, **look) as (left, right):
        for i, values in enumerate(motor.T):
            marker = MARKERS[i % len(MARKERS)]
            left.plot(iterations, values, lw=1.3, marker=marker, ms=5, label=f"motor {i + 1}")
        logarithmic(left)
        left.legend(ncols=2, fontsize=8)
        for values, label, style, color in (
            (arm_maxdev, "maximum", "s-", COLORS[1]),
            (arm_rms, "RMS", "o-", COLORS[0]),
        ):
            microns = np.asarray(values, np.float64) * 1e6  # a missing value is NaN
            right.plot(iterations, microns, style, color=color, lw=1.3, label=label)
        right.update_datalim([(iterations[0], 0.0)])
        right.autoscale_view()
        right.set_ylim(bottom=0.0)
        right.set_ylabel("tool deviation [µm]")
        right.legend(fontsize=8)
        for axes in (left, right):
            whole_numbers(axes.xaxis)


def _panels(n_iterations: int) -> list[int]:
    """Iterations with a panel: all, or some evenly spread with the first and the last."""
    n_shown = min(n_iterations, MOST_PANELS)
    return sorted({round(k) for k in np.linspace(0, n_iterations - 1, n_shown)})


def _largest(arrays: Sequence[Array]) -> float:
    """The largest magnitude among all finite values; 0 if there are none."""
    values = np.abs(np.concatenate([array.ravel() for array in arrays]))
    return float(values.max(where=np.isfinite(values), initial=0.0))


def _nearest(points: Array, path: Array) -> Array:
    """For each of (N, 2) points the nearest point on the closed polyline `path` (M, 2)."""
    start, step = path, np.roll(path, -1, axis=0) - path
    length2 = np.maximum((step**2).sum(1), np.finfo(float).tiny)
    along = ((points[:, None] - start) * step).sum(2) / length2
    foot = start + np.clip(along, 0.0, 1.0)[..., None] * step
    best = ((points[:, None] - foot) ** 2).sum(2).argmin(1)
    return foot[np.arange(len(points)), best]


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
    columns, single = max(2, len(cuts)), len(cuts) == 1  # one cut: its edge beside the sheet
    panel = (WIDTH * 0.92 / columns - 0.4) * reach[1] / reach[0]
    height = max(panel, STRIP) + 1.25 if single else panel + STRIP + 1.9
    figure = new_figure(WIDTH, height)
    ratios = (1.0,) if single else (panel, STRIP)
    grid = figure.add_gridspec(len(ratios), columns, height_ratios=ratios)
    grid.update(left=0.08, right=0.985, hspace=1.5 / (panel + STRIP))
    grid.update(bottom=0.55 / height, top=1.0 - 0.6 / height)
    title = f"Cut with a beam of {beam * 1e3:g} mm, true to scale"
    figure.suptitle(title, x=0.02, y=1.0 - 0.15 / height, ha="left", va="top")
    at = {"loc": "upper right", "bbox_to_anchor": (0.99, 1.0 - 0.08 / height)}
    fills = (("sheet", SHEET), ("kerf", GAP), ("cut out", PIECE))
    legend: list[Artist] = [Patch(fc=fill, ec=REFERENCE, label=name) for name, fill in fills]
    dashed: dict[str, Any] = {"color": COLORS[4], "lw": 0.8, "ls": (0, (4, 3))}
    legend.append(Line2D([], [], label="programmed", **dashed))
    figure.legend(handles=legend, frameon=False, ncols=4, fontsize=8, **at)
    closed = np.vstack([programmed, programmed[:1]]) * 1e3
    for column, (k, cut) in enumerate(cuts):
        axes = figure.add_subplot(grid[0, column], facecolor=SHEET)
        for offset, color in ((cut.outer, GAP), (cut.inner, PIECE)):
            edge = cut.edge(offset)
            axes.fill(*(edge[np.isfinite(edge).all(axis=1)] * 1e3).T, color=color, lw=0.0)
        axes.plot(*closed.T, **dashed)
        axes.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]), aspect="equal")
        axes.set_title(f"k = {k}    {measure} {_microns(cut.roundness)}", fontsize=9)
        axes.set(xlabel="x [mm]", ylabel="y [mm]" if column == 0 else "")
        for axis, n in ((axes.xaxis, 9), (axes.yaxis, min(9, max(1, int(panel / TICK))))):
            axis.set_major_locator(MaxNLocator(n, steps=[1, 2, 5, 10], min_n_ticks=1))
    edge_axes = figure.add_subplot(grid[0, 1] if single else grid[1, :])
    for (k, cut), color in zip(cuts, (COLORS[1], COLORS[0], *COLORS[2:]), strict=False):
        style = {"color": color, "lw": 1.3, "label": f"k = {k}"}
        edge_axes.plot(arc_length * 1e3, cut.hole_deviation * 1e6, **style)
    edge_axes.axhline(0.0, color=REFERENCE, lw=1.0)
    edge_axes.set_title(f"Edge of the hole ({measure}: its range)", loc="left", fontsize=10)
    limits = 0.0, float(arc_length[-1]) * 1e3
    edge_axes.set(xlabel="arc length [mm]", ylabel="deviation outwards [µm]", xlim=limits)
    edge_axes.grid(True, color="#DDDDDD", lw=0.6)
    if not single:
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
        edge_axes.legend(frameon=False, ncols=len(cuts), fontsize=8, **place)
    save(figure, file)
