"""Picture of a scanned sheet: deviation along its contours."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection

from armside.sim.motion.contour import ClosedCurve, outward_normal
from armside.sim.scan.reading import BIN, SheetScan

from .canvas import INK, REFERENCE, panels

BAR = 100e-6
"""Deviation that the bar stands for [m]."""
SHARE = 0.03
"""Length of that bar over the size of the sheet, unless deviations are large."""
LONGEST = 0.06
"""Length of the largest deviation over the size of the sheet."""


def scan_map(
    file: Path,
    scan: SheetScan,
    drawing: Mapping[str, ClosedCurve],
    title: str,
    what: str = "beam",
) -> None:
    """Contours as drawn, in grey, and beside them the deviation of the beam, or what else it is of,
    magnified and coloured."""
    drawn = {
        name: curve.point(np.linspace(0.0, curve.length * (1.0 - 1e-9), 800))
        for name, curve in drawing.items()
    }
    low, high = (f(np.vstack(list(drawn.values())), axis=0) for f in (np.min, np.max))
    size = float((high - low).max())
    worst = max(float(np.abs(c.deviation).max(initial=0.0)) for c in scan.contours.values())
    times = min(SHARE * size / BAR, LONGEST * size / max(worst, 1e-9))
    limit = 1e6 * max(worst, 1e-9)
    ratio = float(np.clip((high - low)[1] / (high - low)[0], 0.3, 1.6))
    labels = ("x of the drawing [mm]", "y of the drawing [mm]")
    with panels(file, (8.0, 1.6 + 6.4 * ratio), title=title, labels=labels) as (axes,):
        for points in drawn.values():
            axes.plot(*(1e3 * points).T, color=REFERENCE, lw=0.8, zorder=1)
        for name, of in scan.contours.items():
            curve = drawing[name]
            foot, normal = curve.point(of.arc_length), outward_normal(curve.tangent(of.arc_length))
            at = 1e3 * (foot + times * of.deviation[:, np.newaxis] * normal)
            whole = np.diff(of.arc_length) < 1.5 * BIN
            pieces = np.stack([at[:-1], at[1:]], axis=1)[whole]
            lines = LineCollection(
                list(pieces), array=1e6 * of.deviation[:-1][whole], cmap="coolwarm", lw=2.2
            )
            lines.set_clim(-limit, limit)
            axes.add_collection(lines)
            place = 1e3 * curve.point(np.linspace(0.0, curve.length, 50)).mean(axis=0)
            open_ends = np.linalg.norm(curve.point(curve.length) - curve.point(0.0)) > BIN
            look = {"xytext": (0, 10 * open_ends), "textcoords": "offset points", "ha": "center"}
            axes.annotate(name, place, va="center", fontsize=8, color=INK, **look)
        axes.set_aspect("equal")
        axes.margins(0.1)
        corner = 1e3 * (low - [0.0, 0.12 * size])
        axes.plot(corner[0] + np.array([0.0, 1e3 * times * BAR]), [corner[1]] * 2, color=INK, lw=3)
        text = f"100 µm of deviation (here {times:.0f} times too large); grey line: as drawn"
        axes.annotate(
            text,
            (corner[0] + 1e3 * times * BAR, corner[1]),
            xytext=(6, 0),
            va="center",
            textcoords="offset points",
            fontsize=8,
            color=INK,
        )
        label = f"{what} beside the drawn contour, outwards positive [µm]"
        axes.figure.colorbar(axes.collections[0], ax=axes, label=label, shrink=0.8)
