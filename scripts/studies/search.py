"""The search of `armside tune`: trials of a study until it has as many as were asked for."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.sim.laser.design import Design
from armside.sim.records.summary import plain
from armside.sim.tuning.action import Motors, design_of
from armside.sim.tuning.objective import WORST, Objective, Ratio, gain
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.tool_objective import ToolObjective

from . import study as studies

if TYPE_CHECKING:
    import optuna

FIRST = 3
"""Designs of the nominal robot that are tried on the robot."""
_STREAM, _NOMINAL = 0xA5, 0xA6  # of random designs, apart from the tasks' draws
Evaluate = Callable[["optuna.Trial"], float]


def evaluate(objective: Objective, trial: "optuna.Trial") -> float:
    """Ratio of the design that a trial suggests; WORST, without a run, where its criterion is 1 or
    more. Raises optuna.TrialPruned where its pruner gives the design up."""
    import optuna

    rules = objective.rules
    ratio, hopeless = Ratio(1.0, 1.0), False
    shifts = not isinstance(objective, ToolObjective)
    design = studies.suggest(trial, Motors(rules.motors), rules.n_axes, shifts)
    trial.set_user_attr(studies.CRITERION, criterion := objective.criterion(design))
    if criterion >= 1.0:
        return WORST
    for k, ratio in enumerate(objective.ratios(design), 1):
        trial.report(ratio.measured, k)
        going_on = ratio.measured < WORST and k < rules.iterations
        hopeless = going_on and trial.should_prune()
        if hopeless:
            break
    trial.set_user_attr(studies.TRUE, ratio.true)
    if ratio.notes:
        trial.set_user_attr(studies.NOTES, plain(ratio.notes))
    if hopeless:
        raise optuna.TrialPruned
    return ratio.measured


def random_designs(rules: Rules, seed: int, stream: int = _STREAM) -> Iterator[Design]:
    """Uniformly random designs, without end."""
    rng = np.random.default_rng([seed, stream])
    while True:
        action = rng.uniform(-1.0, 1.0, rules.action_space.shape)
        yield design_of(action, Motors(rules.motors), rules.n_axes)


def random_best(objective: Objective, runs: int, seed: int) -> Design:
    """The best of random designs that cost so many runs of the robots; one at least. Those whose
    criterion is 1 or more are refused, as by `evaluate`."""
    tried: list[tuple[float, Design]] = []
    end, drawn = objective.runs + runs, random_designs(objective.rules, seed)
    for design in (d for d in drawn if objective.criterion(d) < 1.0):
        tried.append((objective.ratio(design).measured, design))
        if objective.runs >= end:
            break
    return min(tried, key=lambda one: one[0])[1]


def nominal_best(
    nominal: Objective, count: int, seed: int, step: Callable[[], None] = lambda: None
) -> list[Design]:
    """The best FIRST of so many random designs, tried on nominal robots, which costs no run of a
    robot; of those alone whose criterion is below 1."""
    tried: list[tuple[float, Design]] = []
    for design in islice(random_designs(nominal.rules, seed, _NOMINAL), count):
        if nominal.rules.criterion(design) < 1.0:
            tried.append((nominal.foreseen(design).measured, design))
        step()
    return [design for _, design in sorted(tried, key=lambda one: one[0])[:FIRST]]


def against_random(
    objective: Objective, judge: Objective, best: Mapping[str, Any], runs: int, seed: int
) -> dict[str, Any]:
    """Gain of the design of a search's best parameters over that of random search with as many
    runs, on the other jobs of `judge`."""
    found = judge.ratio(studies.design_from(best))
    random = judge.ratio(random_best(objective, runs, seed))
    interval = dict(zip(("ratio", "low", "high"), gain(found, random), strict=True))
    return {"runs": runs, "episodes": len(found.logs)} | interval


def search(
    study: "optuna.Study",
    evaluate: Evaluate,
    n_trials: int,
    first: Sequence[dict[str, float]],
    *,
    check: Callable[[], None],
    step: Callable[[], None],
    new_best: Callable[["optuna.trial.FrozenTrial"], None],
) -> None:
    """Evaluate designs, those of the parameters `first` before others, until the study has
    `n_trials` finished trials, other processes' included.

    check: called between trials; what it raises ends the search. step: called for each finished
    trial. new_best: called with each that is better than all before.
    """
    done, best = 0, min((t.value for t in studies.outcomes(study) if t.complete), default=WORST)
    if len(studies.finished(study)) < n_trials:
        for values in first:
            studies.ask_first(study, values, check)
    while True:
        known = min(len(studies.finished(study)), n_trials)
        for _ in range(known - done):
            step()
        done = known
        for trial in studies.bests(study):
            if studies.value(trial) < best:
                best = studies.value(trial)
                new_best(trial)
        if done >= n_trials:
            return
        run_trial(study, evaluate)
        check()


def run_trial(study: "optuna.Study", evaluate: Evaluate) -> None:
    """One more trial. One that another process has taken for dead, as after a machine has slept,
    is left to that process to repeat."""
    import optuna

    taken = False

    def noticing(trial: "optuna.Trial") -> float:
        nonlocal taken
        try:
            return evaluate(trial)
        except optuna.exceptions.UpdateFinishedTrialError:
            taken = True
            raise

    try:
        study.optimize(noticing, n_trials=1)
    except ValueError:  # Optuna cannot end it once more
        if not taken:
            raise
