"""One individual, two of its cuts, and the twin that they make."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.laser import prepare
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import commission, plan
from armside.sim.twin.identification import Identification, parameters_of
from armside.sim.twin.recordings import measured
from armside.sim.twin.sensitivities import Against

INDIVIDUAL = Drawn(2001)


@pytest.fixture(scope="session")
def cut_by():
    """Experiment and run of a cut by the individual."""

    def run(cut, seed=0, correction=None):
        experiment = prepare(replace(cut, individual=INDIVIDUAL), seed=seed)
        zero = np.zeros_like(experiment.loaded.reference)
        return experiment, experiment.plant.run(zero if correction is None else correction)

    return run


@pytest.fixture(scope="session")
def passes(cut_by):
    """The first two cuts of the plan."""
    return [cut_by(cut, seed)[1] for seed, cut in enumerate(plan(2))]


@pytest.fixture(scope="session")
def commissioned(passes):
    cuts = [measured(run, f"cut-{i + 1}") for i, run in enumerate(passes)]
    return commission(cuts, cfg=Identification(steps=3, linearised=(0, 1)))


@pytest.fixture(scope="session")
def twin(commissioned):
    return commissioned.twin


@pytest.fixture(scope="session")
def around(twin, passes):
    """A point away from the design, and what is linearised there."""
    parameters, rng = parameters_of(twin.design), np.random.default_rng(0)
    against = Against(twin.design, parameters, measured(passes[0]))
    spread = 0.3 * parameters.standard_deviation * rng.standard_normal(parameters.size)
    theta = parameters.mean + spread
    return against, theta, *against.linearised(theta)
