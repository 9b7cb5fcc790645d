"""Picture of a plan: the part with its speeds and rapid moves, and the speed along the way."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from armside.arrays import Array
from armside.sim.part.plan import Plan, PlannedCut, rapid_moves

from .laser import COLORS, INK, REFERENCE, new_figure, save

SPACING = 0.5e-3
"""Distance of the points that are drawn [m]."""
MOST_POINTS = 2000
"""Points drawn of one contour."""
MOST_NUMBERS = 60
"""Contours up to which each is numbered."""
COLOUR_MAP = "viridis"


def part_plan(file: Path, plan: Plan) -> None:
    """Write the picture of a plan. Lengths in mm, speeds in mm/s."""
    figure = new_figure(9.6, 8.4)
    top, bottom = figure.subplots(2, 1, height_ratios=(3.2, 1.0))
    figure.subplots_adjust(left=0.08, right=0.985, bottom=0.07, top=0.92, hspace=0.22)
    rapid = sum(cut.rapid for cut in plan.cuts)
    title = f"{len(plan.cuts)} contours, {plan.seconds:.1f} s, rapid moves {1e3 * rapid:.0f} mm"
    figure.suptitle(title, x=0.02, y=0.985, ha="left")
    _draw_part(figure, top, plan)
    _draw_speed(bottom, plan)
    save(figure, file)


def _draw_part(figure: Figure, axes: Axes, plan: Plan) -> None:
    fastest = 1e3 * plan.cutting.speed
    drawn = None
    for i, cut in enumerate(plan.cuts):
        axes.plot(*(1e3 * cut.contour.chain.polygon()).T, color=REFERENCE, lw=0.6)
        s = _places(cut)
        points, speed = (
            1e3 * cut.path.point(s),
            1e3 * np.interp(s, cut.profile.s, cut.profile.speed),
        )
        segments = np.stack([points[:-1], points[1:]], axis=1)
        drawn = LineCollection(list(segments), cmap=COLOUR_MAP, lw=1.8)
        drawn.set_array(0.5 * (speed[:-1] + speed[1:]))
        drawn.set_clim(0.0, fastest)
        axes.add_collection(drawn)
        if len(plan.cuts) <= MOST_NUMBERS:
            axes.annotate(
                f"{i + 1}",
                points[0],
                fontsize=8,
                color=INK,
                xytext=(3, 3),
                textcoords="offset points",
            )
        for first, last in cut.joints:
            axes.plot(*(1e3 * cut.path.point([first, last])).T, color=COLORS[1], lw=4.0)
    for begin, end in 1e3 * rapid_moves(plan):
        axes.plot(*np.array([begin, end]).T, color=COLORS[1], lw=0.8, ls=(0, (4, 3)))
    axes.plot(*(1e3 * plan.part.box[0]), "o", color=COLORS[1], ms=5)
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.margins(0.05)
    assert drawn is not None
    figure.colorbar(drawn, ax=axes, label="speed [mm/s]", pad=0.02, shrink=0.9)
    text = "grey: drawn; dashed: rapid moves from the dot; numbers: order"
    if any(cut.joints for cut in plan.cuts):
        text += "; bars: micro-joints"
    axes.set_title(text, loc="left", fontsize=9)


def _draw_speed(axes: Axes, plan: Plan) -> None:
    """Asked, allowed and reached speed over the length of all cuts, one after the other."""
    begin = 0.0
    asked = 1e3 * plan.cutting.speed
    for i, cut in enumerate(plan.cuts):
        s = begin + 1e3 * cut.profile.s
        label = ("allowed in bends", "reached") if i == 0 else (None, None)
        axes.plot(s, 1e3 * cut.profile.allowed, color=REFERENCE, lw=1.0, label=label[0])
        axes.plot(s, 1e3 * cut.profile.speed, color=COLORS[0], lw=1.2, label=label[1])
        begin += 1e3 * cut.path.length
    axes.axhline(asked, color=COLORS[1], lw=0.8, ls=(0, (4, 3)), label="asked")
    axes.set(xlabel="length of all cuts in their order [mm]", ylabel="speed [mm/s]")
    axes.set_ylim(0.0, 1.25 * asked)
    axes.set_xlim(0.0, begin)
    axes.legend(ncols=3, frameon=False, fontsize=8, loc="upper right")


def _places(cut: PlannedCut) -> Array:
    n = int(np.clip(cut.path.length / SPACING, 40, MOST_POINTS))
    return np.linspace(0.0, cut.path.length, n)
