"""Which parameters of a study matter, and how far that can be told from noise.

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
"""Random orders of the trials: one in twenty tells more by chance than the most telling of them."""


class Importance(NamedTuple):
    """Of one parameter."""

    share: float
    """In being among the best tenth of the trials; all shares add up to 1."""
    by_chance: float
    """The largest that it has where the trials' order is random, on the same scale: a share that is
    not above it tells nothing."""


def importance(study: "optuna.Study") -> dict[str, Importance]:
    """Of each parameter by PED-ANOVA, the largest first.

    Of the complete trials; a design that diverged counts as the worst. Empty while too few trials
    are complete, or where all of them are alike.
    """
    from optuna.trial import TrialState

    trials = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if len(trials) < ENOUGH:
        return {}
    values = np.array([trial.value for trial in trials], dtype=float)
    rng = np.random.default_rng(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # says that the result says nothing
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
    """Of each parameter's best tenth from all, had the trials these values."""
    import optuna

    study = optuna.create_study()
    study.add_trials(
        optuna.trial.create_trial(params=t.params, distributions=t.distributions, value=value)
        for t, value in zip(trials, values.tolist(), strict=True)
    )
    return optuna.importance.PedAnovaImportanceEvaluator().evaluate(study)
