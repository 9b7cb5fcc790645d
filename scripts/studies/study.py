"""Optuna studies of `armside tune`: opened or resumed, their samplers, pruners and trials.

Optuna is imported here only where it is used: it takes half a second.
"""

import json
import logging
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from armside.sim.laser.design import Design
from armside.sim.notes import Cause, Note
from armside.sim.tuning.action import SIX, VARIABLES, Motors, Scale, action_of
from armside.sim.tuning.objective import WORST

from ..shell.errors import InputError
from .storage import SILENCE, connect, fail_silent, reaching

if TYPE_CHECKING:
    import optuna

Sampler = Literal["tpe", "random", "cmaes"]
Pruner = Literal["percentile", "none"]

FIRST_PRUNED = 3
"""The first iteration, counted from 1, after which a design may be given up: one that learns slowly
is behind at first, and one that learns fast may lose again what it had gained."""
STARTUP_TRIALS = 10
"""Complete designs before one is given up. ESTIMATE: as many as TPE draws at random."""
PERCENTILE = 75.0
"""[%] of complete designs, whose ratio at an iteration a design must reach at its best to go on."""
TRUE = "ratio_true"
"""User attribute of a trial: the ground truth of its objective."""
CRITERION = "criterion"
"""User attribute of a trial: sup |Q (1 - L T_u)| of its design; from 1 on it was not run."""
NOTES = "notes"
"""User attribute of a trial: limits that its last runs touched."""
CONFIG_TIMEOUT = 2.0
"""[s], for the process that has made a study to write what it tunes."""


class Outcome(NamedTuple):
    """Outcome of one trial."""

    number: int
    value: float
    """The objective after the last iteration, WORST if it diverged."""
    true: float | None
    """Its ground truth; None where it is not known."""
    complete: bool
    """All iterations were run: the design was not given up."""


def new_sampler(name: Sampler, seed: int) -> "optuna.samplers.BaseSampler":
    """A sampler whose trial n draws from stream n of the seed: processes that share a study never
    repeat each other, and a study that was stopped between trials goes on as if it had not been. A
    trial that was cut short keeps its number, so that those after it draw other designs."""
    from optuna.samplers import BaseSampler, CmaEsSampler, RandomSampler, TPESampler

    def of_seed(seed: int) -> BaseSampler:
        if name == "random":
            return RandomSampler(seed=seed)
        if name == "cmaes":
            return CmaEsSampler(seed=seed)
        return TPESampler(seed=seed, constant_liar=True)

    class PerTrial(BaseSampler):
        def before_trial(self, study: Any, trial: Any) -> None:
            entropy = np.random.SeedSequence([seed, trial.number])
            self._of_trial = of_seed(int(entropy.generate_state(1)[0]))
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
            if hasattr(self, "_of_trial"):  # none before a dead process's trial is given up
                self._of_trial.after_trial(study, trial, state, values)

    return PerTrial()


def new_pruner(name: Pruner) -> "optuna.pruners.BasePruner":
    """A pruner that gives up no design before it can be compared."""
    from optuna.pruners import NopPruner, PercentilePruner

    if name == "none":
        return NopPruner()
    return PercentilePruner(PERCENTILE, STARTUP_TRIALS, FIRST_PRUNED)


def open_study(
    storage: str, name: str, config: dict[str, Any], *, sampler: Sampler, pruner: Pruner, seed: int
) -> "optuna.Study":
    """The study of that name in a storage, new or as other processes have left it. Raises
    InputError where the storage does not answer, is no URL or another program's, its driver is not
    installed, or the study tunes something else than `config`."""
    import optuna
    from optuna.exceptions import DuplicatedStudyError

    optuna.logging.set_verbosity(logging.ERROR)
    drawing, giving_up = new_sampler(sampler, seed), new_pruner(pruner)
    with reaching(storage):
        database = connect(storage)
        with suppress(DuplicatedStudyError):  # of processes that start together, one makes it
            optuna.create_study(storage=database, study_name=name).set_user_attr("config", config)
        study = optuna.load_study(
            storage=database, study_name=name, sampler=drawing, pruner=giving_up
        )
        known = _config(study, config)
    if known != config:
        changed = [key for key in {**known, **config} if known.get(key) != config.get(key)]
        what = f"tunes something else: {', '.join(changed)} differ; give another --study"
        raise InputError(f"study {name!r} {what}")
    return study


def _config(study: "optuna.Study", config: dict[str, Any]) -> dict[str, Any]:
    """The configuration that a study tunes. The process that has made the study may be about to
    write it; where that was killed in between, `config` becomes its configuration."""
    end = time.monotonic() + CONFIG_TIMEOUT
    while (known := study.user_attrs.get("config")) is None and time.monotonic() < end:
        time.sleep(0.1)
    if known is None:
        study.set_user_attr("config", config)
        known = study.user_attrs["config"]
    return known


def suggest(
    trial: "optuna.Trial", motors: Motors, n_axes: int = SIX, shifts: bool = True
) -> Design:
    """Ask the study for a design; one without a shift where the law has none."""
    values: dict[str, tuple[Any, ...]] = {}
    for v in VARIABLES:
        if v.scale is Scale.WHOLE:
            ask = partial(trial.suggest_int, low=int(v.low), high=int(v.high) * shifts)
        else:
            log = v.scale is Scale.LOGARITHMIC
            ask = partial(trial.suggest_float, low=v.low, high=v.high, log=log)
        names = [v.name] if motors is Motors.SHARED else parameter_names(v.name, n_axes)
        values[v.name] = tuple(map(ask, names))
    return Design(**values)


def parameter_names(variable: str, n_axes: int = SIX) -> list[str]:
    """Names of the parameters of all motors."""
    return [f"{variable}_{i}" for i in range(1, n_axes + 1)]


def parameters(design: Design, motors: Motors, n_axes: int = SIX) -> dict[str, float]:
    """A design as the parameters of a study."""
    if motors is Motors.SHARED:
        return {v.name: getattr(design, v.name)[0] for v in VARIABLES}
    return {
        name: value
        for variable, values in design.arrays(n_axes).items()
        for name, value in zip(parameter_names(variable, n_axes), values.tolist(), strict=True)
    }


def ask_first(
    study: "optuna.Study", values: dict[str, float], check: Callable[[], None] = lambda: None
) -> None:
    """Queue a design as the next trial, unless it was tried, is waiting, or is running elsewhere.
    One whose trial failed, or whose process was killed, is queued again. A killed process is known
    by its silence, which is waited for; what `check` raises ends that."""
    from optuna.trial import TrialState

    # The database counts whole seconds, and one more must have passed.
    end = time.monotonic() + SILENCE + 2.0
    while True:
        fail_silent(study)
        trials = study.get_trials(deepcopy=False)
        known = {t.state for t in trials if t.system_attrs.get("fixed_params", t.params) == values}
        if TrialState.RUNNING not in known or time.monotonic() >= end:
            break
        check()
        time.sleep(0.2)
    if not known - {TrialState.FAIL}:
        study.enqueue_trial(values)


def finished(study: "optuna.Study") -> list["optuna.trial.FrozenTrial"]:
    """Trials that ran to their end or were pruned, in the order of their numbers."""
    from optuna.trial import TrialState

    return study.get_trials(deepcopy=False, states=(TrialState.COMPLETE, TrialState.PRUNED))


def outcomes(study: "optuna.Study") -> list[Outcome]:
    """Outcomes of all finished trials."""
    from optuna.trial import TrialState

    return [
        Outcome(t.number, value(t), t.user_attrs.get(TRUE), t.state is TrialState.COMPLETE)
        for t in finished(study)
    ]


def runs(study: "optuna.Study", episodes: int, iterations: int, held: int = 1) -> int:
    """Runs of robots that the finished trials took, those before learning left out; held: runs
    after the last update."""
    updates = (len(t.intermediate_values) for t in finished(study))
    return episodes * sum(n + held * (n == iterations) for n in updates)


def bests(study: "optuna.Study") -> list["optuna.trial.FrozenTrial"]:
    """Each complete trial that was better than all before it, and did not diverge."""
    from optuna.trial import TrialState

    found: list[optuna.trial.FrozenTrial] = []
    for trial in study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        if value(trial) < (value(found[-1]) if found else WORST):
            found.append(trial)
    return found


def notes_of_best(study: "optuna.Study") -> list[Note]:
    """Limits that the runs with the best design touched."""
    return [
        Note(cause=Cause(one["cause"]), text=f"with the best design {one['text']}")
        for trial in bests(study)[-1:]
        for one in trial.user_attrs.get(NOTES, [])
    ]


def value(trial: "optuna.trial.FrozenTrial") -> float:
    """The objective of a finished trial, or what it last reported when it was given up."""
    assert trial.value is not None
    return trial.value


def load_design(file: Path) -> Design:
    """The best design of a search: shared by all motors, or one for each. Raises ValueError for a
    file that does not exist, is no summary of `armside tune`, or found no design."""
    try:
        return design_from(json.loads(file.read_text(encoding="utf-8"))["best"])
    except FileNotFoundError:
        raise ValueError(f"{file} does not exist") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{file} is no summary.json of armside tune") from error


def design_from(params: Mapping[str, Any]) -> Design:
    """The design of a study's parameters, shared or of each motor. Raises KeyError for others."""

    def names(variable: str) -> list[str]:
        n_axes = sum(name.startswith(f"{variable}_") for name in params)
        return [variable] if variable in params else parameter_names(variable, max(n_axes, 1))

    return Design(**{v.name: tuple(params[name] for name in names(v.name)) for v in VARIABLES})


def first_action(file: Path | None, motors: Motors, n_axes: int = SIX) -> np.ndarray:
    """Action of the design in a file, (3,) or (3 n,); without one, of the middle of the ranges.
    Raises ValueError as `load_design`, and for a design out of the ranges."""
    if file is None:
        return np.zeros(len(VARIABLES) * motors.count(n_axes), np.float32)
    return action_of(load_design(file), motors, n_axes)


def whole_batches(steps: int, batch: int) -> int:
    """Steps rounded up to whole batches: the network is updated after each."""
    return -(-steps // batch) * batch
