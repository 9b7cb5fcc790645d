"""Figure of a comparison of laws: error over iterations, with the prediction."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.ticker import MaxNLocator

from armside.ilc.workbench.compare import LawRun

from ..workbench.results import groups, label, mean_norms
from .laser import COLORS, MARKERS, new_figure, save

MOST_MARKERS = 12
"""Markers on a curve."""
POINT, RING = 4.0, 8.0
"""Sizes of the markers of measured and predicted errors [points]."""


def draw_convergence(file: Path, title: str, runs: Sequence[LawRun]) -> None:
    """||e_k|| of each law on a logarithmic axis, repetitions as a band.

    Predicted ones are dashed, with hollow markers around the measured ones, so that both show where
    they agree. Of more than six laws two have one colour.
    """
    figure = new_figure(7.2, 4.4)
    figure.set_layout_engine("constrained")
    axes = figure.subplots()
    levels = len({run.noise for run in runs}) > 1
    predicted = False
    for i, group in enumerate(groups(runs)):
        colour, norms = COLORS[i % len(COLORS)], mean_norms(group)
        k = group[0].first_k + np.arange(len(norms))
        every = max(1, len(k) // MOST_MARKERS)
        marker = MARKERS[i // len(COLORS) % len(MARKERS)]
        name = label(group[0], levels)
        axes.plot(k, norms, color=colour, marker=marker, ms=POINT, markevery=every, label=name)
        if len(group) > 1:
            full = [run.norms for run in group if len(run.norms) == len(norms)]
            axes.fill_between(
                k, np.min(full, axis=0), np.max(full, axis=0), color=colour, alpha=0.2
            )
        if (seen := group[0].prediction) is not None:
            hollow = {"marker": marker, "mfc": "none", "ms": RING, "markevery": every}
            axes.plot(k, seen.errors[: len(k)], color=colour, ls="--", lw=1.0, **hollow)
            predicted = True
    if predicted:
        about = {"color": "#777777", "ls": "--", "lw": 1.0, "marker": "o", "mfc": "none"}
        axes.plot([], [], **about, ms=RING, label="predicted by the model")
    axes.set_yscale("log", nonpositive="mask")
    axes.set(xlabel="iteration k", ylabel="||e_k||")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(True, which="major", color="#DDDDDD", lw=0.6)
    axes.set_title(title, loc="left")
    figure.legend(frameon=False, fontsize=8, loc="outside right upper")
    save(figure, file)
