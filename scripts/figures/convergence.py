"""Figure of a comparison of laws: error over iterations, with the prediction."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armside.ilc.workbench.compare import LawRun

from ..workbench.law_results import groups, label, mean_norms
from .canvas import COLORS, MARKERS, panels, whole_numbers

MOST_MARKERS = 12
"""Markers on a curve."""
POINT, RING = 4.0, 8.0
"""Sizes of the markers of measured and predicted errors [points]."""


def draw_convergence(file: Path, title: str, runs: Sequence[LawRun]) -> None:
    """||e_k|| of each law on a logarithmic axis, repetitions as a band.

    Predicted ones are dashed, with hollow markers around the measured ones, so that both show where
    they agree. Of more than six laws two have one colour.
    """
    levels = len({run.noise for run in runs}) > 1
    hollow = {"ls": "--", "lw": 1.0, "mfc": "none", "ms": RING}
    predicted = False
    labels = "iteration k", "||e_k||"
    with panels(file, (7.2, 4.4), titles=[title], labels=labels, large=True, ruled=True) as (axes,):
        for i, group in enumerate(groups(runs)):
            color, norms = COLORS[i % len(COLORS)], mean_norms(group)
            k = group[0].first_k + np.arange(len(norms))
            marker = MARKERS[i // len(COLORS) % len(MARKERS)]
            shown = {"color": color, "marker": marker, "markevery": max(1, len(k) // MOST_MARKERS)}
            axes.plot(k, norms, ms=POINT, label=label(group[0], levels), **shown)
            if len(group) > 1:
                full = [run.norms for run in group if len(run.norms) == len(norms)]
                ends = np.min(full, axis=0), np.max(full, axis=0)
                axes.fill_between(k, *ends, color=color, alpha=0.2)
            if (seen := group[0].prediction) is not None:
                axes.plot(k, seen.errors[: len(k)], **shown, **hollow)
                predicted = True
        if predicted:
            axes.plot([], [], color="#777777", marker="o", label="predicted by the model", **hollow)
        axes.set_yscale("log", nonpositive="mask")
        whole_numbers(axes.xaxis)
        axes.figure.legend(loc="outside right upper", fontsize=8)
