"""Samplers, which propose the designs of a study, and pruners, which give them up.

Optuna is imported here only where it is used: it takes half a second.
"""

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

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


def new_sampler(name: Sampler, seed: int) -> "optuna.samplers.BaseSampler":
    """A sampler whose trial n draws from stream n of the seed: processes that share a study never
    repeat each other, and a study that was stopped between trials goes on as if it had not been. A
    trial that was cut short keeps its number, so that those after it draw other designs."""
    import optuna

    class PerTrial(optuna.samplers.BaseSampler):
        def before_trial(self, study: Any, trial: Any) -> None:
            entropy = np.random.SeedSequence([seed, trial.number])
            self._of_trial = _of_seed(name, int(entropy.generate_state(1)[0]))
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
    import optuna

    if name == "none":
        return optuna.pruners.NopPruner()
    return optuna.pruners.PercentilePruner(
        PERCENTILE, n_startup_trials=STARTUP_TRIALS, n_warmup_steps=FIRST_PRUNED
    )


def _of_seed(name: Sampler, seed: int) -> "optuna.samplers.BaseSampler":
    import optuna

    if name == "random":
        return optuna.samplers.RandomSampler(seed=seed)
    if name == "cmaes":
        return optuna.samplers.CmaEsSampler(seed=seed)
    return optuna.samplers.TPESampler(seed=seed, constant_liar=True)
