"""Results of `armside path-logs`: summary, tables, picture."""

from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.recordings.paths import PathComparison

from ..shell.console import Report
from .canvas import COLORS, INK, REFERENCE, panels

MM = 1e3


def results(done: PathComparison) -> dict[str, Any]:
    """Entries of summary.json. SI units."""
    path = {"length": done.path.length, "tool": done.path.tool, "misfit": done.path.misfit}
    speeds = [
        {
            "speed": one.speed,
            "real_runs": one.n_runs,
            "real": vars(one.real),
            "virtual": vars(one.virtual),
            "virtual_logged": vars(one.virtual_logged),
            "timing_error": one.timing.deviation,
            "timing_correlation": one.timing.correlation,
            "log_period": one.timing.period,
            "scatter_of_perfect_runs": {"mean": one.perfect.mean(), "deviation": one.perfect.std()},
            "unexplained": one.unexplained,
        }
        for one in done.speeds
    ]
    return {"path": path, "speeds": speeds}


def tables(report: Report, done: PathComparison) -> None:
    """Error and scatter by speed, and the timing errors of the log."""
    rows = [
        [
            f"{MM * one.speed:g}",
            *(round(MM * value, 3) for value in (one.real.error, one.real.error_in_plane)),
            *(round(MM * value, 3) for value in (one.virtual.error, one.virtual.error_in_plane)),
        ]
        for one in done.speeds
    ]
    head = ["mm/s", "real", "in plane", "virtual", "in plane"]
    report.table("Error across the path, motor side, mean removed [mm RMS]", head, rows)
    rows = [
        [
            f"{MM * one.speed:g}",
            *(round(MM * v, 4) for v in (one.real.scatter, one.perfect.mean())),
            *(round(MM * v, 4) for v in (one.virtual.scatter, one.virtual_logged.scatter)),
            round(MM * one.unexplained, 4),
        ]
        for one in done.speeds
    ]
    head = ["mm/s", "real", "log of perfect runs", "virtual", "virtual by such a log", "beyond log"]
    report.table("Scatter of repeated runs [mm]", head, rows)
    for one in done.speeds:
        deviations = ", ".join(f"{1e3 * d:.2f}" for d in one.timing.deviation)
        nearest = np.diag(one.timing.correlation, 1).mean()
        report.line(
            f"{MM * one.speed:g} mm/s: sampling instants of the motors off by {deviations} ms; "
            f"correlation {nearest:.2f} of neighbours, {one.timing.correlation[0, -1]:.2f} of the "
            "first and the last"
        )


def draw(file: Path, done: PathComparison) -> None:
    """Error and scatter by speed, real and virtual."""

    def line(axes: Any, values: Any, style: str, color: str, label: str) -> None:
        speed = [MM * one.speed for one in done.speeds]
        axes.semilogy(speed, [MM * value for value in values], style, color=color, label=label)

    look: dict[str, Any] = {"title": "Path of the motors at constant speed", "legends": [0, 1]}
    look |= {"titles": ("Error, mean removed, RMS", "Scatter of repeated runs")}
    look |= {"edges": (0.09, 0.98, 0.14, 0.85), "gaps": (0.3, None)}
    with panels(file, (9.0, 4.2), 1, 2, **look) as (left, right):
        for name, color in (("real", COLORS[1]), ("virtual", COLORS[0])):
            measures = [getattr(one, name) for one in done.speeds]
            line(left, [m.error for m in measures], "o-", color, name)
            flat = [m.error_in_plane for m in measures]
            line(left, flat, "o--", color, f"{name}, in the plane")
            line(right, [m.scatter for m in measures], "o-", color, name)
        perfect = [one.perfect.mean() for one in done.speeds]
        line(right, perfect, "s--", REFERENCE, "log of perfect runs")
        logged = [one.virtual_logged.scatter for one in done.speeds]
        line(right, logged, "s--", INK, "virtual, by such a log")
        for axes in (left, right):
            axes.set(xlabel="programmed speed [mm/s]", ylabel="across the path [mm]")
