"""Every law beside the analysis that predicts it, on random plants and on the joint; refusals."""

import os
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from armside.ilc import Heuristic, ZeroPhaseButterworth, learn
from armside.ilc.analysis import LiftedIteration
from armside.ilc.laws.first_order import Blend, DType, FirstOrder, PType
from armside.ilc.laws.model_based import Gradient, ModelInverse
from armside.ilc.laws.norm_optimal import Constrained, NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System

from .signals import ARX, T_S, N, bump, low_pass

EXAMPLES = 6 if os.environ.get("ARMSIDE_CI") else 3


@st.composite
def stable_plants(draw):
    """Two poles inside 0.9, one or two samples of delay, static gain between 0.5 and 2."""
    radius, angle = draw(st.floats(0.0, 0.9)), draw(st.floats(0.0, 1.5))
    gain, zero = draw(st.floats(0.5, 2.0)), draw(st.floats(-0.5, 1.5))
    a = np.array([1.0, -2 * radius * np.cos(angle), radius**2])
    b = np.array([*([0.0] * draw(st.integers(1, 2))), 1.0, -zero])
    assume(abs(b.sum()) > 0.05)
    return System(b * gain * a.sum() / b.sum(), a, T_S)


LAWS = {
    "heuristic": lambda T: Heuristic(Q=low_pass(), gamma=0.5 / T.static_gain, delta=T.delay),
    "p- and d-type": lambda T: FirstOrder(
        Q=low_pass(8.0),
        L=Blend(
            filters=(PType(gamma=0.4), DType(gamma_d=0.2 * T_S, sample_time=T_S)),
            weights=np.full((N, 2), 1 / T.static_gain),
        ),
    ),
    "model-inverse": lambda T: FirstOrder(
        Q=low_pass(), L=ModelInverse(T_u=T, learned=low_pass(30.0), regularisation=1e-3, rate=0.7)
    ),
    "norm-optimal": lambda T: NormOptimal(
        T_u=T, n_samples=N, criterion=QuadraticCriterion(correction=0.03, change=0.1)
    ),
    "gradient": lambda T: FirstOrder(Q=low_pass(), L=Gradient(T_u=T)),
    "time-varying": lambda T: FirstOrder(
        Q=Blend(
            filters=(low_pass(10.0), low_pass(30.0)),
            weights=np.column_stack((np.linspace(1, 0, N), np.linspace(0, 1, N))),
        ),
        L=PType(gamma=0.4 / T.static_gain, delta=T.delay),
    ),
}


@pytest.mark.parametrize("name", LAWS)
@settings(max_examples=EXAMPLES, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(T_u=stable_plants())
def test_fixed_point_and_rate_are_those_of_the_lifted_analysis(name, T_u):
    law = LAWS[name](T_u)
    lifted = LiftedIteration.build(T_u, law, N)
    assume(lifted.spectral_radius < 0.9)
    reference = bump()
    plant = LinearPlant(T_u=T_u, reference=reference)
    u_inf, e_inf = lifted.fixed_point(reference - plant.run(np.zeros_like(reference)))
    trials = list(learn(plant, law, reference, 250, divergence_ratio=np.inf))
    np.testing.assert_allclose(trials[-1].error, e_inf, atol=1e-7)
    distance = [np.linalg.norm(trial.correction - u_inf) for trial in trials]
    for before, after in pairwise(distance):
        assert after <= lifted.contraction * before * (1 + 1e-9) + 1e-8
    # in the long run any direction decays at the spectral radius: norms of powers bound it
    power = np.linalg.matrix_power(lifted.iteration, 64)
    rate = np.linalg.norm(power, 2) ** (1 / 64)
    assert 0.999 * lifted.spectral_radius <= rate


def test_a_limited_step_on_a_gain_is_clipped_and_not_scaled():
    """Of a plant that is a gain of 1, where samples do not act on each other: (e - u)^2 + u^2."""
    gain = StateSpace(A=[[0.0]], B=[[0.0]], C=[[0.0]], D=[[1.0]], sample_time=T_S)
    law = Constrained(T_u=gain, n_samples=4, limit=1.0, criterion=QuadraticCriterion(change=1.0))
    e = np.array([[0.6], [-1.8], [2.4], [-8.0]])
    np.testing.assert_allclose(law(np.zeros((4, 1)), e), [[0.3], [-0.9], [1.0], [-1.0]], atol=1e-6)


FILTERS = {
    "p": PType(gamma=0.7, delta=3),
    "d": DType(gamma_d=0.01, sample_time=T_S),
    "q": ZeroPhaseButterworth(15.0, T_S),
    "inverse": ModelInverse(T_u=ARX, learned=ZeroPhaseButterworth(20.0, T_S), regularisation=1e-4),
    "gradient": Gradient(T_u=ARX),
}


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("hertz", [1.0, 7.0, 30.0])
def test_a_filter_changes_a_sine_by_its_frequency_response(name, hertz):
    one, omega = FILTERS[name], 2 * np.pi * hertz * T_S
    t = np.arange(3000)
    filtered = one(np.column_stack((np.cos(omega * t), np.sin(omega * t))))
    middle = slice(1000, 2000)
    expected = np.asarray(one.response(np.array([omega])))[0] * np.exp(1j * omega * t)
    got = filtered[:, 0] + 1j * filtered[:, 1]
    np.testing.assert_allclose(got[middle], expected[middle], atol=1e-6)
