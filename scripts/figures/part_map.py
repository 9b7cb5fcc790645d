"""Map of the deviation on a part, before and after learning."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from armside.arrays import Array
from armside.sim.evaluation.contour_error import ContourError
from armside.sim.evaluation.tool_error import signed_distance
from armside.sim.part.motion import PartMotion

from .laser import REFERENCE, new_figure, save

WIDTH = 0.035
"""Largest drawn deviation over the size of the part."""
BAR = 1.15
"""Room for the bar of colours and its label [inch]."""
COLOUR_MAP = "coolwarm"


@dataclass(frozen=True)
class Mapped:
    """One run on the part."""

    k: int
    motion: PartMotion
    contours: Sequence[ContourError]
    rms: float
    """Of all contours [m]."""


def part_map(file: Path, runs: Sequence[Mapped]) -> None:
    """Deviation of each contour's shape, in colour and magnified, a panel for each run."""
    deviations = [_deviations(run) for run in runs]
    every = np.concatenate([d for run in deviations for _, d, _ in run])
    worst = float(np.abs(every).max(initial=1e-9))
    box = np.vstack([cut.turn.polygon() for cut in runs[0].motion.cuts])
    size = np.ptp(box, axis=0)
    factor = _round(WIDTH * float(size.max()) / worst)
    height = np.clip(5.2 * size[1] / size[0], 2.2, 7.0)
    width = 5.6 * len(runs) + 1.4
    figure = new_figure(width, float(height) + 1.3)
    panels = np.atleast_1d(figure.subplots(1, len(runs), sharex=True, sharey=True))
    right = 1.0 - BAR / width
    figure.subplots_adjust(left=0.7 / width, right=right, bottom=0.13, top=0.8, wspace=0.06)
    drawn = None
    for axes, run, found in zip(panels, runs, deviations, strict=True):
        drawn = _draw(axes, run, found, factor, 1e6 * worst)
        axes.set_title(f"k = {run.k}: RMS {1e6 * run.rms:.0f} µm", loc="left", fontsize=9)
        axes.set_xlabel("x [mm]")
    panels[0].set_ylabel("y [mm]")
    assert drawn is not None
    bar = figure.add_axes((right + 0.15 / width, 0.13, 0.15 / width, 0.67))
    figure.colorbar(drawn, cax=bar, label="deviation of the shape [µm]")
    scale = f"magnified {factor:g} times" if factor > 1.0 else "to scale"
    title = f"Tool beside the programmed contours, deviation {scale}"
    figure.suptitle(title, x=0.02, y=0.97, ha="left")
    save(figure, file)


def _deviations(run: Mapped) -> list[tuple[Array, Array, Array]]:
    """Of each contour points (M, 2) [m] in the drawing, deviation (M,) [m] and normal (M, 2)."""
    found = []
    for place, error in zip(run.motion.places, run.contours, strict=True):
        path = error.path[np.isfinite(error.path).all(axis=1)]
        curve, s = place.curve, place.curve.nearest(path)
        tangent = curve.tangent(s)
        normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])
        middle = run.motion.plane.from_base(place.plane.origin)[:2] + np.array(run.motion.middle)
        found.append((curve.point(s) + middle, signed_distance(curve, path), normal))
    return found


def _draw(
    axes: Axes, run: Mapped, found: list[tuple[Array, Array, Array]], factor: float, worst: float
) -> LineCollection:
    drawn = None
    for cut, (foot, deviation, normal) in zip(run.motion.cuts, found, strict=True):
        axes.plot(*(1e3 * cut.turn.polygon()).T, color=REFERENCE, lw=0.7)
        points = 1e3 * (foot + factor * deviation[:, np.newaxis] * normal)
        segments = np.stack([points[:-1], points[1:]], axis=1)
        drawn = LineCollection(list(segments), cmap=COLOUR_MAP, lw=1.6)
        drawn.set_array(1e6 * deviation[:-1])
        drawn.set_clim(-worst, worst)
        axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.margins(0.05)
    assert drawn is not None
    return drawn


def _round(factor: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is not above; at least 1."""
    decade = 10.0 ** np.floor(np.log10(max(factor, 1.0)))
    return max(float(m * decade) for m in (1, 2, 5) if m * decade <= max(factor, 1.0))
