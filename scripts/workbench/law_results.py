"""Results of a comparison of laws: table, summary and files."""

import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.workbench.compare import LawRun, RunState, save_states
from armside.ilc.workbench.signals import write_signal
from armside.sim.controller.stored_correction import REFERENCE
from armside.sim.notes import GROWTH

from ..cutting.earlier import STATE
from ..shell.console import Report

TOOL = "arm_rms"
"""Measure of a virtual robot's tool [m]."""
SHOWN = {TOOL: ("arm RMS [µm]", 1e6)}
"""Heading and factor of a measure in the table; others are shown as they are."""
LABEL = 18
"""Width of a law's label, so that a table with five numbers fits 80 columns."""


def key(law: str, noise: float, repetition: int) -> str:
    """Key of a run's state."""
    return f"{law} | noise {noise!r} | repetition {repetition}"


def groups(runs: Sequence[LawRun]) -> list[list[LawRun]]:
    """Repetitions of one law at one noise level, together."""
    found: dict[tuple[str, float], list[LawRun]] = {}
    for run in runs:
        found.setdefault((run.law, run.noise), []).append(run)
    return list(found.values())


def label(run: LawRun, levels: bool) -> str:
    """Name of a run in table and figure; levels: there are several levels of noise."""
    name = re.sub(r"^.*/", "", run.law) if ".py:" in run.law else run.law
    return f"{name} noise {run.noise:g}" if levels else name


def mean_norms(group: Sequence[LawRun]) -> np.ndarray:
    """(K,) mean norms over repetitions; NaN where one had diverged and ended."""
    n = max(len(run.norms) for run in group)
    rows = [np.pad(run.norms, (0, n - len(run.norms)), constant_values=np.nan) for run in group]
    return np.mean(rows, axis=0)


def row(run: LawRun) -> dict[str, Any]:
    """Entry of `summary.json`."""
    seen = run.prediction
    predicted = seen and {
        "criterion": seen.contraction,
        "spectral_radius": seen.spectral_radius,
        "error_two": seen.errors,
    }
    names = run.measures[0] if run.measures else {}
    return {
        "law": run.law,
        "noise": run.noise,
        "repetition": run.repetition,
        "first_k": run.first_k,
        "error_two": run.norms,
        "error_inf": run.largest,
        **{name: [each[name] for each in run.measures] for name in names},
        "diverged": run.diverged,
        "predicted": predicted,
    }


def show(report: Report, title: str, runs: Sequence[LawRun]) -> None:
    """Tables of first and last error beside the prediction."""
    together = groups(runs)
    levels = len({run.noise for run in runs}) > 1
    first, last = runs[0].first_k, max(run.first_k + len(run.norms) for run in runs) - 1
    at = [f"k = {k}" for k in dict.fromkeys((first, last))]
    heads = ["law", *at, "predicted", "criterion", "radius"]
    table = []
    for group in together:
        norms, seen = mean_norms(group), group[0].prediction
        ends = float(norms[-1]) if len(norms) == last - first + 1 else None
        numbers: list[Any] = [float(norms[0]), None if group[0].diverged else ends][-len(at) :]
        if seen is None:
            numbers += [None] * 3
        else:
            numbers += [float(seen.errors[-1]), seen.contraction, seen.spectral_radius]
        table.append([_folded(label(group[0], levels)), *numbers])
    shown = [
        i for i in range(len(heads)) if i <= len(at) or any(row[i] is not None for row in table)
    ]
    repeated = f", mean of {len(together[0])}" if len(together[0]) > 1 else ""
    report.table(
        f"{title}: ||e_k||{repeated}",
        [heads[i] for i in shown],
        [[row[i] for i in shown] for row in table],
        missing="diverged, or not known for this law",
    )
    if not runs[0].measures:
        return
    ends = {first: 0, last: -1}
    measures = {name: SHOWN.get(name, (name, 1.0)) for name in runs[0].measures[0]}
    heads = [f"{heading}, k = {k}" for heading, _ in measures.values() for k in ends]
    table = [
        [_folded(label(group[0], levels))]
        + [
            factor * float(np.mean([run.measures[at][name] for run in group]))
            for name, (_, factor) in measures.items()
            for at in ends.values()
        ]
        for group in together
    ]
    if measures:
        report.table("Other measures", ["law", *heads], table)


def of_the_tool(runs: Sequence[LawRun]) -> list[str]:
    """Notes on laws that made the tool of a robot worse; the learned motors may have improved."""
    measured = [run for run in runs if run.measures and TOOL in run.measures[0]]
    ends = [(run.measures[0][TOOL], run.measures[-1][TOOL], run.law) for run in measured]
    worse = [each for each in ends if each[1] > GROWTH * each[0]]
    if not worse:
        return []
    (before, *_), (_, after, law) = worse[0], max(worse, key=lambda each: each[1] / each[0])
    count = f"{len(worse)} of {len(measured)} runs made the tool worse"
    return [f"{count}: RMS {1e6 * before:.4g} to {1e6 * after:.4g} um with {law}"]


def _folded(text: str) -> str:
    lines = textwrap.wrap(re.sub(r"([,:])", r"\1 ", text), LABEL)
    return "\n".join(lines)


def write(folder: Any, runs: Sequence[LawRun], reference: Array, sample_time: float) -> list[str]:
    """Write reference (N, n) and corrections as CSV, and the state to go on from; notes on what
    could not be kept."""
    write_signal(folder / REFERENCE, reference, sample_time, "reference")
    for i, group in enumerate(groups(runs)):
        name = re.sub(r"[^A-Za-z0-9]+", "-", label(group[0], False)).strip("-")[:60]
        file: Path = folder / f"correction-{i + 1}-{name}.csv"
        write_signal(file, group[0].correction, sample_time, "u")
    states: dict[str, RunState] = {
        key(run.law, run.noise, run.repetition): run.state for run in runs if run.state is not None
    }
    unstored = save_states(folder / STATE, states)
    kinds = "its memory is not made of numbers, texts, arrays, tuples, lists and dicts"
    return [f"{each} cannot be continued: {kinds}" for each in unstored]
