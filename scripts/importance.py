"""Which parameters of a study matter, told only where the trials can tell.

Optuna is imported here only where it is used: it takes half a second.
"""

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import optuna

AT_LEAST = 50
"""Complete trials: PED-ANOVA wants five in the best tenth. Of 40 random searches for the minimum
of a parabola in one of three parameters it names that one first in 17 after 10 trials, 36 after 20
and 40 after 50."""
FOR_EACH = 5
"""Complete trials per parameter: of eighteen it names the right one first in 31 after 30 trials,
and in 40 after 50, but gives it a share of 0.61 then and of 0.79 after 100."""
SHUFFLES = 19
"""Shares add up to 1 even where nothing matters: the largest of three is 0.65 in the median after
50 trials of noise. The trials' own order must tell more than so many at random: 1 in 20 of noise
passes."""


def importance(study: "optuna.Study") -> dict[str, float]:
    """Share of each parameter in being among the best tenth of the complete trials, by PED-ANOVA.

    A design that diverged counts as the worst. Empty while too few trials are complete, and where
    a random order of them would tell as much.
    """
    from optuna.trial import TrialState

    trials = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if not trials or len(trials) < max(AT_LEAST, FOR_EACH * len(trials[0].params)):
        return {}
    values = np.array([trial.value for trial in trials], dtype=float)
    rng = np.random.default_rng(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # says that the result says nothing
        try:
            found = _divergences(trials, values)
            chance = [_divergences(trials, rng.permutation(values)) for _ in range(SHUFFLES)]
        except (RuntimeError, ValueError, UserWarning):
            return {}
    total = sum(found.values())
    if total <= max(sum(other.values()) for other in chance):
        return {}
    return {name: value / total for name, value in found.items()}


def _divergences(
    trials: "Sequence[optuna.trial.FrozenTrial]", values: np.ndarray
) -> dict[str, float]:
    """Of each parameter's best tenth from all, had the trials these values; the largest first."""
    import optuna

    study = optuna.create_study()
    study.add_trials(
        optuna.trial.create_trial(params=t.params, distributions=t.distributions, value=value)
        for t, value in zip(trials, values.tolist(), strict=True)
    )
    found = optuna.importance.PedAnovaImportanceEvaluator().evaluate(study)
    return dict(sorted(found.items(), key=lambda item: -item[1]))
