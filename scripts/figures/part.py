"""Figures of a part: its plan, and the map of its errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from armside.arrays import Array
from armside.sim.evaluation.tool_error import ToolError, signed_distance
from armside.sim.part.motion import PartMotion
from armside.sim.part.plan import Plan, rapid_moves

from .canvas import COLORS, INK, REFERENCE, panels


@dataclass(frozen=True)
class Mapped:
    """One run on the part."""

    k: int
    motion: PartMotion
    contours: Sequence[ToolError]
    rms: float
    """Of all contours [m]."""


def part_map(file: Path, runs: Sequence[Mapped]) -> None:
    """Contours coloured by the deviation of their shape, a panel and a scale for each run."""
    size = np.ptp(np.vstack([cut.turn.polygon() for cut in runs[0].motion.cuts]), axis=0)
    height = float(np.clip(5.2 * size[1] / size[0], 2.2, 7.0)) + 1.3
    look: dict[str, Any] = {"title": "Deviation of the tool's shape from each contour"}
    look |= {"titles": [f"k = {run.k}: RMS {1e6 * run.rms:.0f} µm" for run in runs]}
    look |= {"labels": ("x [mm]", "y [mm]"), "sharex": True, "sharey": True}
    with panels(file, (6.4 * len(runs), height), 1, len(runs), **look) as grid:
        for axes, run in zip(grid, runs, strict=True):
            found = _deviations(run)
            worst = 1e6 * float(np.abs(np.concatenate([d for _, d in found])).max(initial=1e-9))
            for foot, d in found:
                _coloured(axes, 1e3 * foot, 1e6 * d[:-1], (-worst, worst), "coolwarm", 3.0)
            axes.set_aspect("equal")
            axes.margins(0.05)
            label = f"deviation outwards at k = {run.k} [µm]"
            axes.figure.colorbar(axes.collections[0], ax=axes, label=label, shrink=0.8)


def _deviations(run: Mapped) -> list[tuple[Array, Array]]:
    """Of each contour points (M, 2) [m] in the drawing and deviation (M,) [m]."""
    found = []
    for place, error in zip(run.motion.places, run.contours, strict=True):
        path = error.path[np.isfinite(error.path).all(axis=1)]
        curve, s = place.curve, place.curve.nearest(path)
        middle = run.motion.plane.from_base(place.plane.origin)[:2] + np.array(run.motion.middle)
        found.append((curve.point(s) + middle, signed_distance(curve, path)))
    return found


def _coloured(
    axes: Any, points: Array, values: Array, limits: tuple[float, float], cmap: str, lw: float
) -> None:
    """A line through points (M, 2), coloured by the values (M - 1,) of its pieces."""
    pieces = list(np.stack([points[:-1], points[1:]], axis=1))
    axes.add_collection(LineCollection(pieces, array=values, clim=limits, cmap=cmap, lw=lw))


SPACING = 0.5e-3
"""Distance of the points that are drawn [m]."""
MOST_POINTS = 2000
"""Points drawn of one contour."""
MOST_NUMBERS = 60
"""Contours up to which each is numbered."""


def part_plan(file: Path, plan: Plan) -> None:
    """Write the picture of a plan. Lengths in mm, speeds in mm/s."""
    rapid = sum(cut.rapid for cut in plan.cuts)
    title = f"{len(plan.cuts)} contours, {plan.seconds:.1f} s, rapid moves {1e3 * rapid:.0f} mm"
    look = {"edges": (0.08, 0.985, 0.07, 0.92), "gaps": (None, 0.22)}
    with panels(file, (9.6, 8.4), 2, height_ratios=(3.2, 1.0), **look) as (top, bottom):
        top.figure.suptitle(title, x=0.02, y=0.985, ha="left")
        _draw_part(top, plan)
        _draw_speed(bottom, plan)


def _draw_part(axes: Any, plan: Plan) -> None:
    for i, cut in enumerate(plan.cuts, 1):
        drawn = 1e3 * cut.contour.chain.polygon()
        axes.plot(*drawn.T, color=INK, lw=0.6, zorder=3, label="drawn")  # over what is cut
        n = int(np.clip(cut.path.length / SPACING, 40, MOST_POINTS))
        s = np.linspace(0.0, cut.path.length, n)
        points, speed = cut.path.point(s), np.interp(s, cut.profile.s, cut.profile.speed)
        middle = 0.5e3 * (speed[:-1] + speed[1:])
        limits, place = (0.0, 1e3 * plan.cutting.speed), 1e3 * points[0]
        _coloured(axes, 1e3 * points, middle, limits, "viridis", 1.8)
        if len(plan.cuts) <= MOST_NUMBERS:
            look = {"xytext": (3, 3), "textcoords": "offset points", "fontsize": 8, "color": INK}
            axes.annotate(f"{i}", place, **look)
        for first, last in cut.joints:
            axes.plot(*(1e3 * cut.path.point([first, last])).T, color=COLORS[1], lw=4.0)
    for begin, end in 1e3 * rapid_moves(plan):
        axes.plot(*np.array([begin, end]).T, color=COLORS[1], lw=0.8, ls=(0, (4, 3)))
    axes.plot(*(1e3 * plan.part.box[0]), "o", color=COLORS[1], ms=5)
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.margins(0.05)
    look = {"label": "speed [mm/s]", "pad": 0.02, "shrink": 0.9}
    axes.figure.colorbar(axes.collections[0], ax=axes, **look)
    text = "thin black: drawn; dashed: rapid moves from the dot; numbers: order"
    axes.set_title(text + "; bars: micro-joints" * any(cut.joints for cut in plan.cuts))


def _draw_speed(axes: Axes, plan: Plan) -> None:
    """Asked, allowed and reached speed over the length of all cuts, one after the other."""
    begin, asked = 0.0, 1e3 * plan.cutting.speed
    for i, cut in enumerate(plan.cuts):
        s = begin + 1e3 * cut.profile.s
        label = ("allowed in bends", "reached") if i == 0 else (None, None)
        axes.plot(s, 1e3 * cut.profile.allowed, color=REFERENCE, lw=1.0, label=label[0])
        axes.plot(s, 1e3 * cut.profile.speed, color=COLORS[0], lw=1.2, label=label[1])
        begin += 1e3 * cut.path.length
    axes.axhline(asked, color=COLORS[1], lw=0.8, ls=(0, (4, 3)), label="asked")
    axes.set(xlabel="length of all cuts in their order [mm]", ylabel="speed [mm/s]")
    axes.set(xlim=(0.0, begin), ylim=(0.0, 1.25 * asked))
    axes.legend(ncols=3, loc="upper right")
