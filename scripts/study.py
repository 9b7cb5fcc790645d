"""Optuna studies of `armside tune`: opened or resumed, and what they know so far.

Optuna is imported here only where it is used: it takes half a second.
"""

import logging
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from sim.tuning.design import VARIABLES, Design, Motors, Scale

from .errors import InputError
from .study_storage import connect, reaching

if TYPE_CHECKING:
    import optuna

Sampler = Literal["tpe", "random", "cmaes"]
Pruner = Literal["percentile", "none"]

WORST = 1e3
"""Objective of a design that diverges: no finite one is that bad."""
TRUE = "ratio_true"
"""User attribute of a trial: the objective, had the tool been seen as it was."""
ENOUGH = 5
"""Complete trials, below which importances mean nothing."""
PATIENCE = 3
"""Iterations before a design may be given up: what learns slowly is behind at first, and what
learns fast may lose again what it had gained."""
KEPT = 75.0
"""[%] of complete designs, whose ratio at an iteration a design must reach at its best to go on."""


class Tried(NamedTuple):
    """What became of one design."""

    number: int
    seen: float
    """The objective after the last iteration, WORST if it diverged."""
    true: float | None
    """The same in truth; None where it is not known."""
    whole: bool
    """Tried to the end, not given up."""


def open_study(
    storage: str,
    name: str,
    config: Mapping[str, Any],
    *,
    sampler: Sampler,
    pruner: Pruner,
    seed: int,
) -> "optuna.Study":
    """The study of that name, new or as other processes have left it.

    Args:
        storage: see `study_storage.connect`.
        config: what is tuned; a study of another configuration is refused.

    Raises:
        InputError: the storage does not answer or is no URL, its driver is not installed, or the
            study tunes something else.
    """
    import optuna

    optuna.logging.set_verbosity(logging.ERROR)
    with reaching(storage):
        study = optuna.create_study(
            storage=connect(storage),
            study_name=name,
            load_if_exists=True,
            direction="minimize",
            sampler=_sampler(sampler, seed),
            pruner=_pruner(pruner),
        )
    known = study.user_attrs.get("config")
    if known is None:
        study.set_user_attr("config", dict(config))
    elif known != dict(config):
        changed = [key for key in config if known.get(key) != config[key]]
        raise InputError(
            f"study {name!r} tunes something else: {', '.join(changed)} differ; "
            "give another --study"
        )
    return study


def suggest(trial: "optuna.Trial", motors: Motors) -> Design:
    """Ask the study for a design."""
    values: dict[str, tuple[Any, ...]] = {}
    for variable in VARIABLES:
        names = [variable.name] if motors is Motors.SHARED else parameter_names(variable.name)
        if variable.scale is Scale.WHOLE:
            low, high = int(variable.low), int(variable.high)
            values[variable.name] = tuple(trial.suggest_int(name, low, high) for name in names)
        else:
            log = variable.scale is Scale.LOGARITHMIC
            values[variable.name] = tuple(
                trial.suggest_float(name, variable.low, variable.high, log=log) for name in names
            )
    return Design(**values)


def parameter_names(variable: str) -> list[str]:
    """Names of the parameters of six motors."""
    return [f"{variable}_{i}" for i in range(1, 7)]


def parameters(design: Design, motors: Motors) -> dict[str, float]:
    """A design as the parameters of a study."""
    if motors is Motors.SHARED:
        return {v.name: getattr(design, v.name)[0] for v in VARIABLES}
    return {
        name: value
        for variable, values in design.arrays().items()
        for name, value in zip(parameter_names(variable), values.tolist(), strict=True)
    }


def ask_first(study: "optuna.Study", values: dict[str, float]) -> None:
    """Try a design next, unless it was tried, is waiting, or another process is trying it now.

    One whose trial failed, or whose process was killed, is asked for again.
    """
    import optuna

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        optuna.storages.fail_stale_trials(study)
    if not any(
        trial.system_attrs.get("fixed_params", trial.params) == values
        for trial in study.get_trials(deepcopy=False)
        if trial.state is not optuna.trial.TrialState.FAIL
    ):
        study.enqueue_trial(values)


def finished(study: "optuna.Study") -> list["optuna.trial.FrozenTrial"]:
    """Trials that ran to their end or were pruned, in the order of their numbers."""
    from optuna.trial import TrialState

    return study.get_trials(deepcopy=False, states=(TrialState.COMPLETE, TrialState.PRUNED))


def outcomes(study: "optuna.Study") -> list[Tried]:
    """Of all finished trials."""
    from optuna.trial import TrialState

    return [
        Tried(t.number, t.value, t.user_attrs.get(TRUE), t.state is TrialState.COMPLETE)
        for t in finished(study)
        if t.value is not None
    ]


def bests(study: "optuna.Study") -> list["optuna.trial.FrozenTrial"]:
    """Each complete trial that was better than all before it, and did not diverge."""
    from optuna.trial import TrialState

    found: list[optuna.trial.FrozenTrial] = []
    best = WORST
    for trial in study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        if trial.value is not None and trial.value < best:
            best = trial.value
            found.append(trial)
    return found


def importance(study: "optuna.Study") -> dict[str, float]:
    """Share of each parameter in being among the best tenth, by PED-ANOVA.

    Empty while too few trials are done, or where they are all alike.
    """
    import optuna

    if sum(t.state is optuna.trial.TrialState.COMPLETE for t in study.trials) < ENOUGH:
        return {}
    evaluator = optuna.importance.PedAnovaImportanceEvaluator()
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # says that the result says nothing
        try:
            return optuna.importance.get_param_importances(study, evaluator=evaluator)
        except (RuntimeError, ValueError, UserWarning):
            return {}


def _sampler(name: Sampler, seed: int) -> "optuna.samplers.BaseSampler":
    """Trial n draws from stream n of the seed: processes that share a study never repeat each
    other, and a study that was stopped between trials goes on as if it had not been. A trial that
    was cut short keeps its number, so that those after it draw other designs."""
    import optuna

    class PerTrial(optuna.samplers.BaseSampler):
        def before_trial(self, study: Any, trial: Any) -> None:
            entropy = np.random.SeedSequence([seed, trial.number])
            self._of_trial = _new_sampler(name, int(entropy.generate_state(1)[0]))
            self._of_trial.before_trial(study, trial)

        def infer_relative_search_space(self, study: Any, trial: Any) -> dict[str, Any]:
            return self._of_trial.infer_relative_search_space(study, trial)

        def sample_relative(self, study: Any, trial: Any, search_space: Any) -> dict[str, Any]:
            return self._of_trial.sample_relative(study, trial, search_space)

        def sample_independent(
            self, study: Any, trial: Any, param_name: str, param_distribution: Any
        ) -> Any:
            return self._of_trial.sample_independent(study, trial, param_name, param_distribution)

        def after_trial(self, study: Any, trial: Any, state: Any, values: Any) -> None:
            self._of_trial.after_trial(study, trial, state, values)

    return PerTrial()


def _pruner(name: Pruner) -> "optuna.pruners.BasePruner":
    import optuna

    if name == "none":
        return optuna.pruners.NopPruner()
    return optuna.pruners.PercentilePruner(KEPT, n_startup_trials=10, n_warmup_steps=PATIENCE)


def _new_sampler(name: Sampler, seed: int) -> "optuna.samplers.BaseSampler":
    import optuna

    if name == "random":
        return optuna.samplers.RandomSampler(seed=seed)
    if name == "cmaes":
        return optuna.samplers.CmaEsSampler(seed=seed)
    return optuna.samplers.TPESampler(seed=seed, constant_liar=True)
