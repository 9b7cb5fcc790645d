"""Figures, table and replay of `armside compare`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.laser.comparison import Case, rms
from armside.sim.laser.experiment import Iteration

from .canvas import COLORS, MARKERS, logarithmic, panels, whole_numbers

NAMES = {
    "motor": "motors",
    "estimate": "estimate",
    "tracker": "laser tracker",
    "oracle": "ground truth",
    "twin": "motors, first run by a twin",
}
"""Measured outputs as table and figure call them."""
Learned = Mapping[str, list[Iteration]]
"""Iterations by measured output."""
NARROWEST = 6.6
"""Width of `compare.png` that its legend needs [inch]."""
TITLE = "Tool deviation, RMS (9.6) [µm], of the first run, after five updates and at the end"


def _shown(k: Sequence[int]) -> list[int]:
    """Places of the first of these iterations, of that after five updates, and of the last."""
    return [0, *([k.index(5)] if 5 in k[1:-1] else []), -1]


def columns(k: Sequence[int]) -> list[str]:
    """Heads of the table, for runs of these iterations."""
    shown = (f"k = {k[i]}" for i in _shown(k))
    return ["pose", "speed [mm/s]", "learned from", *shown, "last / uncorrected"]


def table(rows: Sequence[Mapping[str, Any]], k: Sequence[int]) -> list[list[Any]]:
    """Rows of the table with these columns, from the comparisons of summary.json."""
    found: list[list[Any]] = []
    for row in rows:
        rms, end = row["arm_rms"], " (diverged)" if row["diverged"] else ""
        microns = [1e6 * rms[min(i, len(rms) - 1)] for i in _shown(k)]
        place = [row["pose"], 1e3 * row["reached_speed"], NAMES[row["measure"]] + end]
        found.append([*place, *microns, rms[-1] / row["uncorrected"]])
    return found


def learned(file: Path, cases: Sequence[Case], found: Sequence[Learned]) -> None:
    """Arm RMS [m] over iterations, a panel per cut, a curve per measure; logarithmic."""
    n_columns = len({case.cut.pose for case in cases})
    n_rows = -(-len(cases) // n_columns)
    width, height = max(3.3 * n_columns + 0.6, NARROWEST), 2.6 * n_rows + 1.0
    edges = 0.75 / width, 0.985, 0.55 / height, 1.0 - 0.95 / height
    look: dict[str, Any] = {"title": "Tool deviation over learning, by what is learned from"}
    look |= {"labels": ("iteration k", "tool deviation, RMS [µm]"), "ruled": True}
    look |= {"edges": edges, "gaps": (0.08, 0.22), "sharex": True, "sharey": True}
    with panels(file, (width, height), n_rows, n_columns, **look) as grid:
        for axes, case, of in zip(grid, cases, found, strict=False):
            for name, iterations in of.items():
                i = list(NAMES).index(name)
                style = {"marker": MARKERS[i], "color": COLORS[i], "label": NAMES[name]}
                at = [each.k for each in iterations]
                axes.plot(at, np.array(rms(iterations)) * 1e6, ms=4, lw=1.2, **style)
            logarithmic(axes)
            whole_numbers(axes.xaxis)
            speed = 1e3 * case.experiment().motion.reached_speed
            axes.set_title(f"{case.cut.pose}, {speed:.0f} mm/s")
        handles, labels = grid[0].get_legend_handles_labels()
        at = (0.0, 1.0 - 0.3 / height)
        grid[0].figure.legend(
            handles, labels, ncols=len(labels), loc="upper left", bbox_to_anchor=at
        )


def write_replay(file: Path, case: Case, found: Learned) -> None:
    """The first run, then the last of each measured output, as k = 0 .. 4."""
    from armside.sim.records.signals import RecordedRun
    from armside.sim.replay.scene import Scene, write_scenes

    experiment = case.experiment()
    shown = [found["motor"][0], *(iterations[-1] for iterations in found.values())]
    runs = [
        RecordedRun(k=k, recording=it.run.recording, tracker=it.run.tracker)
        for k, it in enumerate(shown)
    ]
    mj, motion = experiment.loaded.model.mj, experiment.motion
    write_scenes(file, [Scene(mj=mj, runs=runs, motion=motion, robot=case.cut.cell.robot)])
