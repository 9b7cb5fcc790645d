"""Figures of `armside tune`: the history of a search, and the importance of parameters."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from armside.sim.tuning.objective import WORST

from ..studies.study import Outcome
from .canvas import COLORS, REFERENCE, panels, whole_numbers

HEIGHT = 4.2
"""[inch], of the history."""
COLUMNS = 3
"""Of its legend."""
LEVELS = (1.0, 2.0, 3.0, 5.0, 7.0)
"""Numbers on the axis of a ratio, times powers of ten."""


def history(file: Path, outcomes: Sequence[Outcome], *, sensor: str) -> None:
    """Draw each design's ratio, and the best so far, measured and true.

    outcomes: at least one is complete and did not diverge.
    sensor: words for the sensor of the ratio, such as "by the tracker".
    """
    number = np.array([one.number for one in outcomes])
    value = np.array([one.value for one in outcomes])
    true = np.array([one.true for one in outcomes], dtype=float)
    complete = np.array([one.complete for one in outcomes])
    diverged = value >= WORST
    # The number of the best design so far; -1 before there is a finite one below WORST.
    bound = np.minimum.accumulate(np.r_[WORST, np.where(complete, value, np.inf)])
    holder = np.maximum.accumulate(np.where(bound[1:] < bound[:-1], np.arange(len(value)), -1))
    with panels(file, (8.0, HEIGHT), edges=(0.1, 0.98, 0.12, 0.9)) as (axes,):
        axes.axhline(1.0, color="#DDDDDD", lw=1.0)
        for chosen, marker, label in (
            (complete & ~diverged, "o", "design"),
            (~complete, "x", "given up, at its last iteration"),
        ):
            if chosen.any():
                axes.plot(number[chosen], value[chosen], marker, ms=4, color=REFERENCE, label=label)
        if diverged.any():
            edge = np.full(diverged.sum(), 0.98)
            above = {"transform": axes.get_xaxis_transform(), "label": "diverged, beyond the axis"}
            axes.plot(number[diverged], edge, "^", ms=5, color=COLORS[1], **above)
        for values, style, color, label in (
            (value, "-", COLORS[0], f"best so far, {sensor}"),
            (true, "--", COLORS[2], "same design, ground truth"),
        ):
            best = np.where(holder < 0, np.nan, values[holder])
            axes.step(number, best, style, where="post", color=color, label=label)
        axes.set_yscale("log")
        axes.margins(y=0.1)
        axes.yaxis.set_major_locator(LogLocator(subs=LEVELS))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
        whole_numbers(axes.xaxis)
        axes.set(xlabel="trial", ylabel="RMS of the tool, after learning / before")
        legend = axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=COLUMNS)
        rows = -(-len(legend.get_texts()) // COLUMNS)
        axes.figure.subplots_adjust(top=1.0 - (0.2 + 0.2 * rows) / HEIGHT)


def importance(file: Path, found: Mapping[str, Mapping[str, float]]) -> None:
    """Draw the importance of each parameter, largest on top, beside the most by chance.

    found: `Importance` of each as a mapping, the largest first.
    """
    names, height = list(found)[::-1], 1.4 + 0.28 * len(found)
    share, chance = ([found[name][key] for name in names] for key in ("share", "by_chance"))
    colors = [COLORS[0] if s > c else REFERENCE for s, c in zip(share, chance, strict=True)]
    edges = 0.15, 0.98, 0.6 / height, 1.0 - 0.35 / height
    with panels(file, (7.0, height), edges=edges) as (axes,):
        axes.barh(names, share, color=colors)
        label = "largest that chance gives"
        axes.plot(chance, names, "|", ms=16, mew=2.0, color=COLORS[1], label=label)
        axes.set_xlim(0.0, 1.05 * max(1.0, *chance))
        axes.set_xlabel("share in what sets the best designs apart (PED-ANOVA); grey: as by chance")
        axes.figure.legend(loc="upper right")
