"""Importances of parameters: named where the trials can tell, and not told from noise."""

import numpy as np
import optuna
import pytest

from armside.scripts.studies.report import importance


def _searched(rng, n_trials, n_parameters, objective):
    """A random search in which `objective` says what a point is worth."""
    unit = optuna.distributions.FloatDistribution(0.0, 1.0)
    study = optuna.create_study()
    for x in rng.uniform(size=(n_trials, n_parameters)):
        params = {f"x{i}": value for i, value in enumerate(x.tolist())}
        kinds = dict.fromkeys(params, unit)
        study.add_trial(
            optuna.trial.create_trial(params=params, distributions=kinds, value=objective(x))
        )
    return study


@pytest.mark.parametrize(("n_parameters", "n_trials"), [(3, 60), (18, 100)])
def test_importances_name_what_matters(n_parameters, n_trials):
    rng = np.random.default_rng(0)
    found = importance(_searched(rng, n_trials, n_parameters, lambda x: (x[1] - 0.3) ** 2))
    assert next(iter(found)) == "x1"
    assert [name for name, one in found.items() if one.share > one.by_chance] == ["x1"]
    assert sum(one.share for one in found.values()) == pytest.approx(1.0)


def test_noise_is_not_told_from_chance_and_few_trials_are_not_asked():
    rng = np.random.default_rng(1)
    for _ in range(3):
        found = importance(_searched(rng, 20, 3, lambda x: rng.normal()))
        assert all(one.share <= one.by_chance for one in found.values())
    assert importance(_searched(rng, 9, 3, lambda x: (x[1] - 0.3) ** 2)) == {}
