"""Figures of learning on the arm side, from arrays alone."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from .laser import COLORS, MARKERS, new_figure, save

NAMES = ("motor", "estimate", "tracker", "oracle")


def learned(
    file: Path, titles: Sequence[str], curves: Sequence[Mapping[str, Array]], n_columns: int
) -> None:
    """Arm RMS [m] over iterations, a panel per cut, a curve per measure; logarithmic."""
    n_rows = -(-len(curves) // n_columns)
    width, height = 3.3 * n_columns + 0.6, 2.6 * n_rows + 0.6
    figure = new_figure(width, height)
    panels = figure.subplots(n_rows, n_columns, sharex=True, sharey=True, squeeze=False)
    figure.subplots_adjust(left=0.75 / width, right=0.985, wspace=0.08)
    figure.subplots_adjust(bottom=0.55 / height, top=1.0 - 0.55 / height, hspace=0.22)
    for axes, title, of in zip(panels.flat, titles, curves, strict=False):
        for name, values in of.items():
            i = NAMES.index(name)
            style = {"marker": MARKERS[i], "color": COLORS[i], "label": name}
            axes.plot(np.arange(len(values)), values * 1e6, ms=4, lw=1.2, **style)
        axes.set_yscale("log")
        axes.set_title(title, loc="left", fontsize=9)
        axes.grid(True, which="major", color="#DDDDDD", lw=0.6)
    for axes in panels[-1]:
        axes.set_xlabel("iteration k")
    for axes in panels[:, 0]:
        axes.set_ylabel("arm RMS [µm]")
    handles, labels = panels.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=4, frameon=False, fontsize=8)
    save(figure, file)


def imu_quality(file: Path, rows: Sequence[Sequence[Any]]) -> None:
    """Error of the estimate by sensors used and their quality: a bar per variant and pose.

    rows: (name, error at p1, p2, p3 [um], ...), as `verifications.controls` has them.
    """
    figure = new_figure(8.0, 0.34 * len(rows) + 0.9)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.32, right=0.985, bottom=0.07, top=0.95)
    place = np.arange(len(rows))[::-1]
    for i, pose in enumerate(("p1", "p2", "p3")):
        errors = [row[1 + i] for row in rows]
        axes.barh(place + 0.26 * (1 - i), errors, 0.24, color=COLORS[i], label=pose)
    axes.set_yticks(place, [str(row[0]) for row in rows])
    axes.set_xlabel("error of the tool's path, 3D RMS [µm]")
    axes.set_title("Error of the estimate by sensors and quality of the IMU", loc="left")
    axes.grid(True, axis="x", color="#DDDDDD", lw=0.6)
    axes.legend(frameon=False, fontsize=8)
    save(figure, file)
