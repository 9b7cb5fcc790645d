"""Figures of `armside tune`: how the search went, and what mattered."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .figures import COLORS, INK, REFERENCE

SHOWN = 1.2
"""Designs worse than this lie at the upper edge: one that diverges has no finite ratio."""


def history(file: Path, trials: Sequence[tuple[int, float, bool]]) -> None:
    """Each trial's ratio and the best so far. trials: (number, ratio, tried to the end)."""
    number, value = np.array([(n, min(v, SHOWN)) for n, v, _ in trials]).T
    whole = np.array([complete for *_, complete in trials])
    figure = Figure((7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    axes.plot(number[whole], value[whole], "o", ms=3, color=REFERENCE, label="trial")
    if not whole.all():
        label = "given up before its end"
        axes.plot(number[~whole], value[~whole], "x", ms=4, color=REFERENCE, label=label)
    best = np.minimum.accumulate(np.where(whole, value, np.inf))
    axes.step(number, best, where="post", color=COLORS[0], label="best so far")
    axes.set_ylim(0.0, 1.05 * value.max())
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("trial")
    axes.set_ylabel("tool RMS after learning / before")
    axes.legend(frameon=False)
    _save(figure, file)


def importance(file: Path, shares: Mapping[str, float]) -> None:
    """Share of each parameter, largest on top."""
    names = sorted(shares, key=lambda name: shares[name])
    figure = Figure((7.0, 1.2 + 0.28 * max(len(names), 2)), layout="constrained")
    axes = figure.subplots()
    axes.barh(names, [shares[name] for name in names], color=COLORS[0])
    if not names:
        axes.text(0.5, 0.5, "too few trials", ha="center", transform=axes.transAxes, color=INK)
    axes.set_xlabel("share in what made designs good")
    _save(figure, file)


def _save(figure: Figure, file: Path) -> None:
    FigureCanvasAgg(figure)
    figure.savefig(file, dpi=120, metadata={"Software": None})
