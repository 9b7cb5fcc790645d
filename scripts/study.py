"""Optuna studies of `armside tune`: opened or resumed, and what they know so far.

Optuna is imported here only where it is used: it takes half a second.
"""

import logging
import random
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sim.tuning.design import VARIABLES, Design, Motors, Scale

from .errors import InputError, one_line

if TYPE_CHECKING:
    import optuna

Sampler = Literal["tpe", "random", "cmaes"]
Pruner = Literal["percentile", "none"]

CONNECT_TIMEOUT = 10
"""[s], for a storage server to answer."""
ENOUGH = 5
"""Complete trials, below which importances mean nothing."""
PATIENCE = 3
"""Iterations before a design may be given up: what learns slowly is behind at first, and what
learns fast may lose again what it had gained."""
KEPT = 75.0
"""[%] of designs that go on."""
ATTEMPTS = 5
"""At making the tables of a new database, which others may be making too."""


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
        storage: database URL as SQLAlchemy writes them; the folder of an SQLite file is made.
        config: what is tuned; a study of another configuration is refused.

    Raises:
        InputError: the storage does not answer or is no URL, its driver is not installed, or the
            study tunes something else.
    """
    import optuna
    from sqlalchemy.exc import SQLAlchemyError

    optuna.logging.set_verbosity(logging.ERROR)
    try:
        _make_folder(storage)
        study = optuna.create_study(
            storage=_connect(storage),
            study_name=name,
            load_if_exists=True,
            direction="minimize",
            sampler=_sampler(sampler, seed),
            pruner=_pruner(pruner),
        )
    except ImportError as error:
        raise InputError(
            f"storage {_shown(storage)} needs a database driver that is not installed; "
            "for PostgreSQL: pip install 'armside[postgres]'"
        ) from error
    except (SQLAlchemyError, OSError, ValueError) as error:
        raise InputError(f"storage {_shown(storage)} does not answer: {_reason(error)}") from error
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


def finished(study: "optuna.Study") -> list["optuna.trial.FrozenTrial"]:
    """Trials that ran to their end or were pruned, in the order of their numbers."""
    from optuna.trial import TrialState

    return study.get_trials(deepcopy=False, states=(TrialState.COMPLETE, TrialState.PRUNED))


def values(study: "optuna.Study") -> list[tuple[int, float, bool]]:
    """(number, last ratio, tried to the end) of each finished trial."""
    from optuna.trial import TrialState

    return [
        (t.number, t.value, t.state is TrialState.COMPLETE)
        for t in finished(study)
        if t.value is not None
    ]


def bests(study: "optuna.Study") -> list["optuna.trial.FrozenTrial"]:
    """Each complete trial that was better than all before it."""
    from optuna.trial import TrialState

    found: list[optuna.trial.FrozenTrial] = []
    for trial in study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        if trial.value is not None and (not found or trial.value < (found[-1].value or 0.0)):
            found.append(trial)
    return found


def importance(study: "optuna.Study") -> dict[str, float]:
    """Share of each parameter in what made designs good; empty while too few trials are done."""
    import optuna

    if sum(t.state is optuna.trial.TrialState.COMPLETE for t in study.trials) < ENOUGH:
        return {}
    try:
        return optuna.importance.get_param_importances(study)
    except (RuntimeError, ValueError):
        return {}


def _connect(storage: str) -> "optuna.storages.RDBStorage":
    """The database, with its tables. Processes that make them at the same moment try again."""
    import optuna
    from sqlalchemy.exc import IntegrityError, ProgrammingError

    for attempt in range(1, ATTEMPTS + 1):
        try:
            return optuna.storages.RDBStorage(storage, engine_kwargs=_engine_options(storage))
        except (IntegrityError, ProgrammingError):
            if attempt == ATTEMPTS:
                raise
            time.sleep(random.uniform(0.5, 1.5))
    raise AssertionError("unreachable")


def _sampler(name: Sampler, seed: int) -> "optuna.samplers.BaseSampler":
    """Every trial draws from a stream of its own: processes that share a study never repeat each
    other, and a study that is resumed goes on as if it had not been interrupted."""
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


def _engine_options(storage: str) -> dict[str, Any]:
    if storage.startswith("sqlite"):
        return {"connect_args": {"timeout": 60}}  # another process may be writing
    return {"connect_args": {"connect_timeout": CONNECT_TIMEOUT}, "pool_pre_ping": True}


def _make_folder(storage: str) -> None:
    if storage.startswith("sqlite:///"):
        Path(storage.removeprefix("sqlite:///")).parent.mkdir(parents=True, exist_ok=True)


def _shown(storage: str) -> str:
    """The URL without its password."""
    from sqlalchemy.engine import make_url
    from sqlalchemy.exc import ArgumentError

    try:
        return repr(make_url(storage).render_as_string(hide_password=True))
    except (ArgumentError, ValueError):
        return repr(storage)


def _reason(error: Exception) -> str:
    """The driver's own words, without SQLAlchemy's around them."""
    cause = getattr(error, "orig", None) or error
    return one_line(cause).split(" Is the server running")[0]
