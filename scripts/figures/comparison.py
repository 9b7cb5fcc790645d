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


def columns(k: Sequence[int]) -> list[str]:
    """Heads of the table, for runs of these iterations."""
    early = [f"k = {_early(k)}"] if _early(k) not in (k[0], k[-1]) else []
    heads = ["pose", "speed [mm/s]", "learned from", f"k = {k[0]}", *early, f"k = {k[-1]}"]
    return [*heads, "last / uncorrected"]


def table(rows: Sequence[Mapping[str, Any]], k: Sequence[int]) -> list[list[Any]]:
    """Rows of the table with these columns, from the comparisons of summary.json."""
    found: list[list[Any]] = []
    early = _early(k)
    for row in rows:
        rms, end = row["arm_rms"], " (diverged)" if row["diverged"] else ""
        shown = [0, *([k.index(early)] if early not in (k[0], k[-1]) else []), -1]
        microns = [1e6 * rms[min(i, len(rms) - 1)] for i in shown]
        place = [row["pose"], 1e3 * row["reached_speed"], NAMES[row["measure"]] + end]
        found.append([*place, *microns, rms[-1] / row["uncorrected"]])
    return found


def _early(k: Sequence[int]) -> int:
    """The iteration after five updates; the last where there are none between."""
    return 5 if 5 in k else k[-1]


def learned(file: Path, cases: Sequence[Case], found: Sequence[Learned]) -> None:
    """Arm RMS [m] over iterations, a panel per cut, a curve per measure; logarithmic."""
    n_columns = len({case.cut.pose for case in cases})
    n_rows = -(-len(cases) // n_columns)
    width, height = max(3.3 * n_columns + 0.6, NARROWEST), 2.6 * n_rows + 1.0
    edges = 0.75 / width, 0.985, 0.55 / height, 1.0 - 0.95 / height
    title = "Tool deviation over learning, by what is learned from"
    look = {"edges": edges, "gaps": (0.08, 0.22), "sharex": True, "sharey": True, "title": title}
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
            axes.grid(True)
        for axes in grid[-n_columns:]:
            axes.set_xlabel("iteration k")
        for axes in grid[::n_columns]:
            axes.set_ylabel("tool deviation, RMS [µm]")
        handles, labels = grid[0].get_legend_handles_labels()
        place = {"loc": "upper left", "bbox_to_anchor": (0.0, 1.0 - 0.3 / height)}
        grid[0].figure.legend(handles, labels, ncols=len(labels), **place)


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
