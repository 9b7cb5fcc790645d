"""Claims of `armside verify tuning` and `tuning-iterations`: designs and a policy on sealed seeds.

`scripts/studies/tuned/` holds results of `armside tune` and `armside train`; docs/tuning.md has the
commands.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from armside.sim.evaluation.check import Check, Table, all_hold, mean_interval
from armside.sim.laser.design import THESIS, Design
from armside.sim.notes import Note, counted
from armside.sim.robot.run import cores
from armside.sim.tuning.action import VARIABLES, Motors
from armside.sim.tuning.evaluation import Episode, Network, Policy, always, evaluate
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.task import TEST_SEEDS

from ..studies.study import load_design

TUNED = Path(__file__).parents[1] / "studies" / "tuned"
DATA_SEED = 1  # seed of the experiments that models are identified from
TWICE = 10  # iterations, twice the budget that was searched and trained with
SIGNIFICANT = 3.0  # standard errors by which a mean must be better than another


def tuning(seeds: Iterable[int]) -> Table:
    """Seed i is the sealed episode TEST_SEEDS[i]; every baseline meets the same episodes."""
    shared, each = (Rules(motors=m.value, sealed=True) for m in (Motors.SHARED, Motors.EACH))
    found = _episodes(
        seeds,
        {
            "thesis design": (shared, always(THESIS, Motors.SHARED)),
            "best fixed design by search": (shared, always(searched(), Motors.SHARED)),
            "designs from identified models": (each, always(identified(), Motors.EACH)),
            "learned policy": (shared, Network.load(TUNED / "policy.npz")),
        },
    )
    logs = {name: np.log([e.ratio for e in episodes]) for name, episodes in found.items()}
    thesis, search = logs["thesis design"], logs["best fixed design by search"]
    rows = []
    for name, log in logs.items():
        mean, quantile, worst = np.exp(log.mean()), np.quantile(np.exp(log), 0.9), np.exp(log.max())
        middle = np.median([1e6 * episode.rms_true[-1] for episode in found[name]])
        others = (_against(log, thesis), _against(log, search))
        diverged = sum(episode.diverged for episode in found[name])
        rows.append((name, float(mean), *others, *map(float, (quantile, worst, middle)), diverged))
    better = ("best fixed design by search", "learned policy")
    return Table(
        f"Tool RMS after five iterations, {len(thesis)} sealed episodes",
        (
            *("baseline", "RMS after / before, geometric mean"),
            "RMS over the thesis design's (95 % interval), episodes won",
            "RMS over the best fixed design's (95 % interval), episodes won",
            *("90 % quantile of after / before", "worst after / before"),
            *("median RMS after [µm]", "diverged"),
        ),
        rows,
        [_beats(name, "thesis design", logs) for name in better],
        _notes(found),
    )


def iterations(seeds: Iterable[int]) -> Table:
    """Error after each iteration, over episodes that do not diverge; designs beyond the budget."""
    long, budget = Rules(iterations=TWICE, sealed=True), Rules(sealed=True)
    found = _episodes(
        seeds,
        {
            "thesis design": (long, always(THESIS, Motors.SHARED)),
            "best fixed design by search": (long, always(searched(), Motors.SHARED)),
            "learned policy": (budget, Network.load(TUNED / "policy.npz")),
        },
    )
    n, said = len(found["thesis design"]), _notes(found)
    found = {name: [e for e in each if not e.diverged] for name, each in found.items()}
    rows = {
        name: np.exp(np.mean([np.log(e.rms_true[1:] / e.rms_true[0]) for e in episodes], axis=0))
        for name, episodes in found.items()
    }
    chosen = [
        [d.gamma[0] for d in e.decisions if isinstance(d, Design)] for e in found["learned policy"]
    ]
    rows["gain γ of the learned policy, mean"] = np.mean(chosen, axis=0)
    search = rows["best fixed design by search"]
    more = "the searched design is made for its budget: after ten iterations it leaves more"
    return Table(
        f"RMS of the tool over that before learning, geometric mean, {n} episodes",
        ("", *(f"k = {k}" for k in range(1, TWICE + 1))),
        [(name, *row.tolist(), *[np.nan] * (TWICE - len(row))) for name, row in rows.items()],
        [all_hold(more, search[-1] > search[4])],
        said,
    )


def _notes(found: Mapping[str, Sequence[Episode]]) -> list[Note]:
    """Limits that changed runs of any baseline."""
    every = (episode.notes for episodes in found.values() for episode in episodes)
    return counted(chain.from_iterable(every), "runs")


def _episodes(
    seeds: Iterable[int], baselines: Mapping[str, tuple[Rules, Policy]]
) -> dict[str, list[Episode]]:
    """The sealed episodes of each baseline, by its name."""
    sealed = [TEST_SEEDS[i] for i in seeds]
    return {
        name: list(evaluate(rules, sealed, policy, threads=cores()))
        for name, (rules, policy) in baselines.items()
    }


def _against(one: np.ndarray, other: np.ndarray) -> str:
    """Geometric mean of one over the other in the same episodes, its interval, and episodes won."""
    if one is other:
        return "-"
    gain = one - other
    mean, low, high = np.exp([gain.mean(), *mean_interval(gain)])
    won = int((gain < 0.0).sum())
    return f"{mean:.2f} ({low:.2f} to {high:.2f}), {won} of {len(gain)}"


def _paired(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, float]:
    """Differences in the same episodes, and the standard error of their mean."""
    gain = one - other
    return gain, float(gain.std(ddof=1) / np.sqrt(len(gain))) if len(gain) > 1 else np.inf


def _beats(name: str, other: str, logs: Mapping[str, np.ndarray]) -> Check:
    gain, error = _paired(logs[other], logs[name])
    less = f"the {name} leaves less error at the tool than the {other}"
    by = f"(mean by more than {SIGNIFICANT:g} standard errors)"
    return all_hold(f"{less} {by}", gain.mean() > SIGNIFICANT * error)


def searched() -> Design:
    """The design that `armside tune` found."""
    return load_design(TUNED / "design.json")


def identified() -> Design:
    """A design for each motor from its own model, identified at p1, as `armside reproduce 9` does.

    Values beyond the ranges of the env are brought to their ends.
    """
    from armside.ilc.analysis.proposal import design_for
    from armside.sim.calibration.bands import SPEEDS, identify

    from ..thesis.chapter9.designs import CUTOFFS
    from ..thesis.chapter9.table import STUDIES

    jobs = STUDIES["identification"].jobs(DATA_SEED)
    results = {speed: jobs["p1", speed].run() for speed in SPEEDS}
    models = [identify(results, (motor,)) for motor in range(6)]
    proposals = [design_for(model.system, CUTOFFS, fit=model.fit) for model in models]
    gamma, delta, cutoff = (
        tuple(float(np.clip(getattr(p, v.name), v.low, v.high)) for p in proposals)
        for v in VARIABLES
    )
    return Design(gamma=gamma, delta=tuple(int(d) for d in delta), cutoff=cutoff)
