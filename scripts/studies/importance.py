"""Importance of a study's parameters, and its significance.

Optuna is imported here only where it is used: it takes half a second.
"""

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import optuna

ENOUGH = 10
"""Complete trials, of which the best tenth is one."""
SHUFFLES = 19
"""Random permutations of the objective: one study in twenty exceeds their largest by chance."""


class Importance(NamedTuple):
    """Importance of one parameter."""

    share: float
    """Fraction of the importance of all parameters for being among the best tenth of the trials."""
    by_chance: float
    """The largest in random orders of the trials, on the same scale: a fraction that is not above
    it is not significant."""


def importance(study: "optuna.Study") -> dict[str, Importance]:
    """Importance of each parameter by PED-ANOVA over the complete trials, the largest first.

    A design that diverged counts as the worst. Empty while too few trials are complete, or where
    all of them are alike.
    """
    from optuna.trial import TrialState

    trials = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if len(trials) < ENOUGH:
        return {}
    values = np.array([trial.value for trial in trials], dtype=float)
    rng = np.random.default_rng(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # warns of a void result
        try:
            found = _divergences(trials, values)
            random = [_divergences(trials, rng.permutation(values)) for _ in range(SHUFFLES)]
        except (RuntimeError, ValueError, UserWarning):
            return {}
    total = sum(found.values())
    if not total > 0.0:
        return {}
    return {
        name: Importance(value / total, max(other[name] for other in random) / total)
        for name, value in sorted(found.items(), key=lambda item: -item[1])
    }


def _divergences(
    trials: "Sequence[optuna.trial.FrozenTrial]", values: np.ndarray
) -> dict[str, float]:
    """Divergence of each parameter's best tenth from all, if the trials had these values."""
    import optuna

    study = optuna.create_study()
    study.add_trials(
        optuna.trial.create_trial(params=t.params, distributions=t.distributions, value=value)
        for t, value in zip(trials, values.tolist(), strict=True)
    )
    return optuna.importance.PedAnovaImportanceEvaluator().evaluate(study)
