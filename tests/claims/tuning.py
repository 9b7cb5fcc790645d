"""Designs and a policy on sealed seeds: every baseline meets the same episodes.

`tuning-iterations`: error after each iteration, over episodes that do not diverge, and designs
beyond their budget. `tuning-growth`: designs that `armside tune` returns, held for 40 updates.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from armside.arrays import Array
from armside.scripts import cli
from armside.scripts.studies.study import load_design
from armside.sim.laser.design import Design
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import iterate
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.results import results
from armside.sim.laser.specification import Cut
from armside.sim.tuning.action import Motors
from armside.sim.tuning.rules import Rules

from . import _episodes
from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_once
from ._episodes import BY_MODELS, BY_POLICY, BY_SEARCH, BY_THESIS
from .tuning_tasks import against

SIGNIFICANT = 3.0  # standard errors by which a mean must be better than another


def run(seeds: tuple[int, ...], tally: Tally) -> Iterator[Row]:
    shared, each = (Rules(motors=m.value, sealed=True) for m in (Motors.SHARED, Motors.EACH))
    rules = {BY_THESIS: shared, BY_SEARCH: shared, BY_MODELS: each, BY_POLICY: shared}
    yield from _episodes.episodes(seeds, rules, tally)


def shown(rows: Rows) -> Iterator[Row]:
    logs = _logs(rows)
    for name, own in rows.by("baseline").items():
        log = logs[name]
        yield {
            "baseline": name,
            "RMS after / before, geometric mean": float(np.exp(log.mean())),
            "RMS over the thesis design's (95 % interval)": against(log, logs[BY_THESIS]),
            "RMS over the best fixed design's (95 % interval)": against(log, logs[BY_SEARCH]),
            "90 % quantile of after / before": float(np.quantile(np.exp(log), 0.9)),
            "worst after / before": float(np.exp(log.max())),
            "median RMS after [µm]": float(np.median([1e6 * rms[-1] for rms in own["rms"]])),
            "diverged": int(own["diverged"].sum()),
        }


def _logs(rows: Rows) -> Mapping[str, np.ndarray]:
    return {name: np.log(own["ratio"]) for name, own in rows.by("baseline").items()}


def checks(rows: Rows) -> Iterator[Check]:
    logs = _logs(rows)
    for name in (BY_SEARCH, BY_POLICY):
        yield beats(name, BY_THESIS, logs)


def beats(name: str, other: str, logs: Mapping[str, np.ndarray]) -> Check:
    """The mean of the differences in the same episodes, in its standard errors."""
    gain = logs[other] - logs[name]
    error = float(gain.std(ddof=1) / np.sqrt(len(gain))) if len(gain) > 1 else np.inf
    less = f"the {name} leaves less error at the tool than the {other}"
    by = f"(mean by more than {SIGNIFICANT:g} standard errors)"
    return all_hold(f"{less} {by}", gain.mean() > SIGNIFICANT * error)


CLAIM = Claim(
    title="Tool RMS after five iterations, {n} sealed episodes",
    seeds=100,
    cases=at_once,
    run=run,
    checks=checks,
    shown=shown,
    processes=1,
)


TWICE = 10  # iterations, twice the budget that was searched and trained with


def run_iterations(seeds: tuple[int, ...], tally: Tally) -> Iterator[Row]:
    long, budget = Rules(iterations=TWICE, sealed=True), Rules(sealed=True)
    rules = {BY_THESIS: long, BY_SEARCH: long, BY_POLICY: budget}
    yield from _episodes.episodes(seeds, rules, tally)


def means(rows: Rows) -> dict[str, Array]:
    """Geometric mean of the RMS over that before learning, after each iteration."""
    return {
        name: np.exp(np.mean([np.log(r["rms"][1:] / r["rms"][0]) for r in _ended(own)], axis=0))
        for name, own in rows.by("baseline").items()
    }


def _ended(rows: Rows) -> list[Row]:
    return [row for row in rows if not row["diverged"]]


def shown_iterations(rows: Rows) -> Iterator[Row]:
    chosen = [row["gamma"] for row in _ended(rows.by("baseline")[BY_POLICY])]
    listed = means(rows) | {"gain γ of the learned policy, mean": np.mean(chosen, axis=0)}
    for name, values in listed.items():
        padded = [*values.tolist(), *[np.nan] * (TWICE - len(values))]
        yield {"": name} | {f"k = {k}": value for k, value in enumerate(padded, 1)}


def checks_iterations(rows: Rows) -> Iterator[Check]:
    search = means(rows)[BY_SEARCH]
    more = "the searched design is made for its budget: after ten iterations it leaves more"
    yield all_hold(more, search[-1] > search[4])


CLAIM_ITERATIONS = replace(
    CLAIM,
    title="RMS of the tool over that before learning, geometric mean, {n} episodes",
    run=run_iterations,
    checks=checks_iterations,
    shown=shown_iterations,
)


SEARCH = "tune --episodes 6 --trials 60 --alone --quiet"
HELD = 40  # updates
GREW = Design(gamma=(0.298,), delta=(19,), cutoff=(13.0,))
"""What that search returned with seed 1 before it looked past its budget."""


def run_growth(seed: int, tally: Tally) -> Iterator[Row]:
    with TemporaryDirectory() as folder:
        out, storage = Path(folder) / "a", f"sqlite:///{folder}/a.db"
        where = ["--seed", str(seed), "--storage", storage, "--out", str(out)]
        assert cli.main([*SEARCH.split(), *where]) == 0
        design = load_design(out / "summary.json")
    yield grown(f"seed {seed}", design, tally)


def grown(name: str, design: Design, tally: Tally) -> Row:
    """The tool's RMS at p1 and 40 mm/s under a design that is held."""
    experiment = prepare(Cut(), seed=0)
    runs = iterate(experiment, MotorAngles(design).prepare(experiment), HELD)
    found = results(experiment, runs)
    tally.add(found["notes"])
    values = {"gamma": design.gamma[0], "delta": design.delta[0], "cutoff [Hz]": design.cutoff[0]}
    rms = [1e6 * row["arm_rms"] for row in found["iterations"]]
    # Learning that diverges ends early.
    tool = {f"k = {k} [µm]": rms[k] if k < len(rms) else np.inf for k in (0, 5, HELD)}
    return {"search": name, **values, "criterion": Rules().criterion(design), **tool}


def checks_growth(rows: Rows) -> Iterator[Check]:
    yield all_hold("every design has a criterion below 1", rows["criterion"] < 1.0)
    late, early = rows[f"k = {HELD} [µm]"], rows["k = 5 [µm]"]
    more = f"after {HELD} updates the tool is at most 1.2 times as far off as after 5"
    yield all_hold(more, late <= 1.2 * early)


CLAIM_GROWTH = Claim(
    title="Designs that armside tune returns, held at p1",
    seeds=5,
    run=run_growth,
    checks=checks_growth,
    processes=1,
)
