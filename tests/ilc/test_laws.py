"""Every law beside the analysis that predicts it, on random plants and on the joint; refusals."""

import os
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from armside.ilc import Heuristic, ZeroPhaseButterworth, learn
from armside.ilc.analysis import LiftedIteration
from armside.ilc.filters import ALL_PASS
from armside.ilc.laws.first_order import Blend, DType, FirstOrder, MatrixGain, PType
from armside.ilc.laws.memory import (
    Adaptive,
    FrequencyKalman,
    HighOrder,
    internal_model,
    periodic_pattern,
)
from armside.ilc.laws.model_based import Gradient, ModelInverse
from armside.ilc.laws.model_free import MeasuredGradient, b_splines
from armside.ilc.laws.norm_optimal import Constrained, NormOptimal, PointToPoint
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.laws.repetitive import Repetitive
from armside.ilc.laws.robust import h_infinity
from armside.ilc.laws.wrappers import JointSpace, Scheduled
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.models.two_mass import FrictionPlant

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


def test_coupled_motors_have_the_fixed_point_of_their_lifted_iteration():
    T_u = SystemMatrix(((ARX, ARX * 0.4), (ARX * -0.3, ARX * 0.8)))
    gamma = 0.6 * np.linalg.inv([[1.0, 0.4], [-0.3, 0.8]])
    law = FirstOrder(Q=low_pass(10.0), L=MatrixGain(gamma=gamma, delta=5))
    reference = bump(80, 2)
    plant = LinearPlant(T_u=T_u, reference=reference)
    lifted = LiftedIteration.build(T_u, law, 80, 2)
    u, e = lifted.fixed_point(reference - plant.run(np.zeros_like(reference)))
    *_, last = learn(plant, law, reference, 200)
    np.testing.assert_allclose(last.correction, u, atol=1e-9)
    np.testing.assert_allclose(last.error, e, atol=1e-9)


FIVE = QuadraticCriterion(error=np.ones(5), change=1)
NOTHING = System([0.0], [1.0], T_S)
FADING = FirstOrder(L=Blend(filters=(PType(),), weights=np.ones((90, 1))))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: DType(gamma_d=np.nan, sample_time=T_S), "gamma_d must be finite"),
        (lambda: MatrixGain(gamma=np.ones((2, 3))), r"finite \(n, n\) matrix"),
        (lambda: HighOrder(alpha=(1,), beta=(1, 2), L=PType()), "equally many"),
        (lambda: internal_model((1.0,), L=PType()), r"pattern must be \(1, d_1"),
        (lambda: internal_model((1, 0, -1), L=PType(), pole=1.0), "pole must be in"),
        (lambda: periodic_pattern(0), "period must be >= 1"),
        (lambda: Adaptive(L=PType(), noise_variance=0, initial_variance=1), "noise_variance"),
        (lambda: Scheduled(laws=()), "at least one law"),
        (lambda: Blend(filters=(PType(),), weights=np.ones((5, 2))), r"shape \(N, 1\)"),
        (lambda: MeasuredGradient(experiment=len, size=0.0), "size must be > 0"),
        (lambda: LinearPlant(T_u=ARX, reference=bump(), noise=1.0), "needs an rng"),
        (lambda: SystemMatrix(((ARX,), (ARX, ARX))), "square matrix"),
        (lambda: System.from_z([1, 0, 0], [1, 0.5], T_S), "numerator degree 2 in q"),
        (lambda: System([1], [0, 1], T_S), "not causal"),
        (lambda: b_splines(10, 3), r"n_basis must be in 4\.\.10"),
        (lambda: FADING.check(60, 1), "weights cover 90 samples, the record 60"),
        (lambda: JointSpace(law=FADING, inverse=np.ones((2, 3))).check(1, 6), "2 motors"),
        (lambda: QuadraticCriterion(correction=0, change=0), "must not both be 0"),
        (lambda: QuadraticCriterion(correction=-1.0), "weight of the correction must be >= 0"),
        (
            lambda: NormOptimal(T_u=ARX, n_samples=N, criterion=FIVE),
            r"weight of the error must be a number, \(90,\)",
        ),
        (lambda: Constrained(T_u=ARX, n_samples=N, limit=0.0), "limit must be > 0"),
        (lambda: Constrained(T_u=ARX, n_samples=N, limit=np.ones(7)), "limit must be a number"),
        (lambda: NormOptimal(T_u=System([0, 1], [1, -1.01], T_S), n_samples=N), "T_u is unstable"),
        (lambda: h_infinity(ARX, low_pass(), n_taps=5, lead=5), "lead must be in 0"),
        (lambda: h_infinity(ARX, low_pass(), uncertainty=-1.0), "uncertainty must be >= 0"),
        (lambda: FrequencyKalman(L=PType(), noise=0.0), "noise must be > 0"),
        (lambda: Repetitive(L=PType(), period=1), "period and begin"),
        (lambda: Repetitive(L=PType(), period=100).check(150, 1), "two laps of 100"),
        (lambda: PointToPoint(T_u=ARX, points=[90], n_samples=90), "must be samples 0 to 89"),
        (lambda: Heuristic(Q=ALL_PASS, gamma=0.0), "gamma must be > 0"),
        (lambda: Heuristic(Q=ALL_PASS, gamma=-0.5), "gamma must be > 0"),
        (lambda: Heuristic(Q=ALL_PASS, gamma=np.nan), "gamma must be > 0"),
        (lambda: Heuristic(Q=ALL_PASS, gamma=(0.9, -0.1)), "gamma must be > 0"),
        (lambda: Heuristic(Q=ALL_PASS, delta=1.5), "whole number of samples"),
        (lambda: Heuristic(Q=ALL_PASS, delta=np.nan), "whole number of samples"),
        (lambda: FrictionPlant(coulomb=-1.0), "coulomb must be"),
        (lambda: FrictionPlant(noise=1.0), "needs an rng"),
        (lambda: FrictionPlant(substeps=0), "substeps"),
        (lambda: Gradient(T_u=NOTHING), "T_u is 0"),
        (lambda: h_infinity(NOTHING, low_pass()), "T_u is 0"),
        (lambda: ModelInverse(T_u=NOTHING, learned=low_pass()), "T_u is 0"),
    ],
)
def test_invalid_design_variables_are_refused_by_name(build, message):
    with pytest.raises(ValueError, match=message):
        build()
