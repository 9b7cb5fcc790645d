"""Samplers of a study by their names."""

import pytest

from armside.scripts.studies.proposals import _of_seed


@pytest.mark.parametrize(
    ("name", "kind"), [("random", "Random"), ("cmaes", "CmaEs"), ("tpe", "TPE")]
)
def test_a_sampler_is_the_one_that_is_named(name, kind):
    samplers = pytest.importorskip("optuna").samplers
    assert type(_of_seed(name, 0)) is getattr(samplers, f"{kind}Sampler")
