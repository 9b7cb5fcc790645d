"""Results of `armside path-logs`: summary, tables, picture."""

from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.recordings.paths import AtSpeed, PathComparison

from ..shell.console import Report
from .laser import COLORS, INK, REFERENCE, new_figure, save

MM = 1e3


def results(done: PathComparison) -> dict[str, Any]:
    """Entries of summary.json. SI units."""
    path = {"length": done.path.length, "tool": done.path.tool, "misfit": done.path.misfit}
    return {"path": path, "speeds": [_row(one) for one in done.speeds]}


def _row(one: AtSpeed) -> dict[str, Any]:
    return {
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
    speed = [MM * one.speed for one in done.speeds]
    figure = new_figure(9.0, 4.2)
    left, right = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.09, right=0.98, bottom=0.14, top=0.85, wspace=0.3)
    for label, color, of in (("real", COLORS[1], "real"), ("virtual", COLORS[0], "virtual")):
        measures = [getattr(one, of) for one in done.speeds]
        left.semilogy(speed, [MM * m.error for m in measures], "o-", color=color, label=label)
        flat = [MM * m.error_in_plane for m in measures]
        left.semilogy(speed, flat, "o--", color=color, label=f"{label}, in the plane")
        scatter = [MM * m.scatter for m in measures]
        right.semilogy(speed, scatter, "o-", color=color, label=label)
    perfect = [MM * one.perfect.mean() for one in done.speeds]
    right.semilogy(speed, perfect, "s--", color=REFERENCE, label="log of perfect runs")
    logged = [MM * one.virtual_logged.scatter for one in done.speeds]
    right.semilogy(speed, logged, "s--", color=INK, label="virtual, by such a log")
    for axes, title in ((left, "Error, mean removed, RMS"), (right, "Scatter of repeated runs")):
        axes.set(xlabel="programmed speed [mm/s]", ylabel="across the path [mm]")
        axes.set_title(title, loc="left", fontsize=9)
        axes.legend(frameon=False, fontsize=8)
    figure.suptitle("Path of the motors at constant speed", x=0.02, ha="left")
    save(figure, file)
