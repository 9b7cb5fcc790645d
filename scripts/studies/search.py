"""The search of `armside tune`: trials of a study until it has as many as were asked for."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from armside.sim.records.summary import plain
from armside.sim.tuning.action import Motors
from armside.sim.tuning.objective import WORST, Objective, Ratio

from . import study as studies

if TYPE_CHECKING:
    import optuna

Evaluate = Callable[["optuna.Trial"], float]


def evaluate(objective: Objective, trial: "optuna.Trial") -> float:
    """Ratio of the design that a trial suggests. Raises optuna.TrialPruned where its pruner gives
    the design up."""
    import optuna

    rules = objective.rules
    ratio, hopeless = Ratio(1.0, 1.0), False
    design = studies.suggest(trial, Motors(rules.motors), rules.n_axes)
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


def search(
    study: "optuna.Study",
    evaluate: Evaluate,
    n_trials: int,
    first: dict[str, float],
    *,
    check: Callable[[], None],
    step: Callable[[], None],
    new_best: Callable[["optuna.trial.FrozenTrial"], None],
) -> None:
    """Evaluate designs until the study has `n_trials` finished trials, other processes' included.

    Args:
        first: parameters of the design that is tried first.
        check: called between trials; what it raises ends the search.
        step: called for each finished trial.
        new_best: called with each trial that is better than all before.
    """
    done, best = 0, min((t.value for t in studies.outcomes(study) if t.complete), default=WORST)
    if len(studies.finished(study)) < n_trials:
        studies.ask_first(study, first, check)
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
