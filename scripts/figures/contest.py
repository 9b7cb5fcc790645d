"""Chart of a track: what each entry leaves over its runs, and its harm rate beside."""

from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.contest.judge import LARGEST

from .canvas import COLORS, MARKERS, panels


def draw(file: Path, results: list[dict[str, Any]], title: str) -> None:
    """Geometric mean of the curves by run, the last value held, or ten from where a task was lost;
    and the part of tasks harmed, of which those lost are some."""
    names = [result["entry"]["name"] for result in results]
    look: dict[str, Any] = {"titles": ("left of the error, geometric mean", "tasks harmed")}
    with panels(file, (8.4, 3.8), 1, 2, title=title, ruled=True, **look) as axes:
        curves, harm = np.ravel(axes)
        each = [
            [row["curve"] + [LARGEST] * bool(row["reason"]) for row in result["tasks"]]
            for result in results
        ]
        longest = max(len(row) for rows in each for row in rows)
        for i, rows in enumerate(each):
            held = [row + row[-1:] * (longest - len(row)) for row in rows]
            style = {"color": COLORS[i % len(COLORS)], "marker": MARKERS[i // len(COLORS)]}
            mean = np.exp(np.log(np.maximum(held, 1e-4)).mean(axis=0))
            curves.plot(mean, label=names[i], ms=3, markevery=max(1, longest // 8), **style)
        curves.set_yscale("log")
        curves.set_xlabel("run k")
        curves.legend(ncols=2, fontsize=6)
        rates = [np.mean([row["harm"] for row in result["tasks"]]) for result in results]
        harm.barh(names, rates, color="#9A9A9A")
        harm.set_xlim(0.0, 1.0)
        harm.invert_yaxis()
