"""Proposed designs, their expected values, and robustness; values that are refused."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from armside.ilc import Edge, Heuristic, learn
from armside.ilc.analysis import LiftedIteration
from armside.ilc.analysis.criterion import heuristic_criterion
from armside.ilc.analysis.proposal import propose
from armside.ilc.analysis.robustness import (
    PARAMETERS,
    MonteCarlo,
    contraction,
    contraction_map,
    monte_carlo,
)
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth, shift
from armside.ilc.laws.first_order import Blend, DType, MatrixGain, PType
from armside.ilc.laws.model_based import Beyond, ModelInverse
from armside.ilc.laws.model_free import FiniteDifference
from armside.ilc.laws.norm_optimal import Constrained, PointToPoint
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.laws.repetitive import Repetitive
from armside.ilc.laws.transfer import BasisFunctions, RationalBasis
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.file import read_model
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System, tustin, zoh
from armside.ilc.models.two_mass import PdController, TwoMassLoop

from .signals import ARX

EXAMPLES = 15 if os.environ.get("ARMSIDE_CI") else 6


def bump(n):
    t = np.linspace(0, 1, n)
    return np.exp(-(((t - 0.4) / 0.08) ** 2))[:, None]


def test_the_servo_of_chapter_9_gets_the_shift_that_its_delay_and_lag_ask_for():
    assert propose(ARX, 10.0).delta == 6


@settings(max_examples=EXAMPLES, deadline=None)
@given(
    pole=st.floats(0.0, 0.9),
    delay=st.integers(1, 8),
    gain=st.floats(0.2, 5.0),
    bandwidth=st.floats(2.0, 20.0),
)
def test_the_error_falls_at_least_as_fast_as_proposed(pole, delay, gain, bandwidth):
    T_u = System([0.0] * delay + [gain * (1 - pole)], [1, -pole], 0.004)
    proposal = propose(T_u, bandwidth)
    reference = bump(1000)
    trials = list(learn(LinearPlant(T_u=T_u, reference=reference), proposal.law, reference, 120))
    limit = trials[-1].error
    distance = np.array([two_norm(trial.error - limit)[0] for trial in trials[:30]])
    assume(distance[0] > 1e-6)
    k = proposal.iterations_to_5_percent
    assume(k < 30)
    assert distance[k] <= 0.05 * distance[0]


def test_the_predicted_residual_at_a_frequency_is_the_amplitude_of_a_sine_after_learning():
    proposal = propose(ARX, 10.0)
    t = np.arange(3000)[:, None] * 0.004
    sine = np.sin(2 * np.pi * 8.0 * t)
    plant = LinearPlant(T_u=ARX, reference=0 * sine, loads=(sine,))
    *_, last = learn(plant, proposal.law, 0 * sine, 30)
    amplitude = np.sqrt(2 * np.mean(last.error[1000:2000] ** 2))
    assert amplitude == pytest.approx(proposal.residual(8.0), rel=0.01)


def test_the_sentence_names_design_prediction_and_limit():
    sentence = propose(TwoMassLoop().T_motor, 6.0).sentence()
    for part in ("gamma = 1", "delta = 8", "6 Hz", "0.495", "cutoff of 16.8 Hz would no longer"):
        assert part in sentence


def test_an_infeasible_design_states_the_feasible_bandwidth():
    T_arm = TwoMassLoop().T_arm
    with pytest.raises(
        ValueError, match=r"infeasible design: with a cutoff of 45 Hz .* up to"
    ) as e:
        propose(T_arm, 45.0)
    feasible = float(str(e.value).split("up to ")[1].split(" Hz")[0])
    propose(T_arm, 0.98 * feasible)
    with pytest.raises(ValueError, match="infeasible"):
        propose(T_arm, 1.05 * feasible)


def test_no_bandwidth_below_a_thousandth_of_the_asked_one_is_called_feasible():
    """A shift of 8 s would contract far below 0.1 Hz."""
    with pytest.raises(ValueError, match=r"up to 0 Hz one does"):
        propose(TwoMassLoop().T_motor, 45.0, deltas=range(2000, 2001))


def test_a_model_file_gives_the_system_in_either_form(tmp_path):
    file = tmp_path / "model.json"
    file.write_text(json.dumps({"sample_time": 0.004, "b": [0, 0.5], "a": [1, -0.5]}))
    one = read_model(file)
    file.write_text(json.dumps({"sample_time": 0.004, "num": [0.5], "den": [1, -0.5]}))
    np.testing.assert_array_equal(one.b, read_model(file).b)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not a readable JSON file"),
        ("[]", "must hold an object"),
        ('{"b": [1], "a": [1]}', "lacks sample_time"),
        ('{"b": [1], "a": [0, 1], "sample_time": 0.01}', "not causal"),
        ('{"num": [1, 0, 0], "den": [1, 0.5], "sample_time": 0.01}', "not causal"),
        ('{"b": "x", "a": [1], "sample_time": 0.01}', "model.json: "),
    ],
)
def test_a_model_file_that_is_no_model_is_refused_with_its_name(tmp_path, text, message):
    file = tmp_path / "model.json"
    file.write_text(text)
    with pytest.raises(ValueError, match=message) as refused:
        read_model(file)
    assert "model.json" in str(refused.value)


# Robustness of the two-mass joint

LOOP = TwoMassLoop()
CHAPTER_8 = Heuristic(gamma=0.9, delta=5, Q=propose(LOOP.T_motor, 17.0).Q)


def test_the_map_holds_the_nominal_value_at_factor_one_and_shows_divergence_far_from_it():
    grid = contraction_map(LOOP, CHAPTER_8, ("Jm", [0.5, 1.0, 4.5]), ("k", [1.0, 5.0]))
    assert grid.shape == (3, 2)
    assert grid[1, 0] == pytest.approx(0.8142, abs=2e-3)
    assert grid[2, 1] > 1.0 > grid[0, 0]


def test_joints_of_the_map_and_of_the_sample_are_those_of_their_parameters():
    def of(**factors):
        scaled = {name: getattr(LOOP.joint, name) * f for name, f in factors.items()}
        other = replace(LOOP.joint, **scaled)
        return contraction(replace(LOOP, joint=other, reference_model=LOOP.joint), CHAPTER_8)

    grid = contraction_map(LOOP, CHAPTER_8, ("Jm", [0.5, 3.0]), ("k", [0.7, 5.0]))
    assert grid[1, 0] == pytest.approx(of(Jm=3.0, k=0.7), rel=1e-12)
    assert grid[0, 1] == pytest.approx(of(Jm=0.5, k=5.0), rel=1e-12)
    assert abs(grid[1, 0] - grid[0, 1]) > 0.01
    drawn = monte_carlo(LOOP, CHAPTER_8, 1.0, 3, np.random.default_rng(1))
    each = [of(**dict(zip(PARAMETERS, row, strict=True))) for row in drawn.factors]
    assert drawn.contraction == pytest.approx(each, rel=1e-12)


def test_a_prediction_of_failure_is_growth_on_the_finite_record():
    other = replace(LOOP, joint=replace(LOOP.joint, Jm=5 * LOOP.joint.Jm, k=5 * LOOP.joint.k))
    assert contraction(other, CHAPTER_8) > 1.2
    law = Heuristic(Q=replace(CHAPTER_8.Q, edge=Edge.REST), gamma=0.9, delta=5)
    assert LiftedIteration.build(other.T_motor, law, 300).contraction > 1.2
    assert LiftedIteration.build(LOOP.T_motor, law, 300).contraction < 1.0


def test_an_unstable_joint_counts_as_not_contracting():
    loop = TwoMassLoop(controller=PdController(Kp=600.0))
    assert contraction(loop, CHAPTER_8) == np.inf


def test_uncertainty_spreads_the_contraction_and_the_seed_fixes_it():
    narrow, wide = (
        monte_carlo(LOOP, CHAPTER_8, spread, 30, np.random.default_rng(1)) for spread in (0.1, 1.0)
    )
    again = monte_carlo(LOOP, CHAPTER_8, 0.1, 30, np.random.default_rng(1))
    np.testing.assert_array_equal(narrow.contraction, again.contraction)
    assert np.ptp(wide.contraction) > 2 * np.ptp(narrow.contraction)
    assert narrow.fraction_converging == 1.0


@pytest.mark.parametrize("name", ["k", "fm"])
def test_the_most_harmful_parameter_is_the_one_that_the_contraction_follows(name):
    factors = np.exp(np.random.default_rng(3).uniform(-1.0, 1.0, (40, len(PARAMETERS))))
    follows = 0.5 + np.abs(np.log(factors[:, PARAMETERS.index(name)]))
    assert MonteCarlo(follows, factors).most_harmful() == name


N, T_S = 30, 0.01
SERVO = System([0.0, 0.5], [1.0, -0.5], T_S)
LOW = ZeroPhaseButterworth(10.0, T_S)
COMPLEX = np.array([1.0 + 1.0j, 1.0])


@pytest.mark.parametrize(
    "build",
    [
        lambda: System(COMPLEX, [1.0], T_S),
        lambda: System([1.0], COMPLEX, T_S),
        lambda: System.from_z([1.0], COMPLEX, T_S),
        lambda: zoh([1.0], COMPLEX, T_S),
        lambda: tustin([1.0], COMPLEX, T_S),
        lambda: MatrixGain(gamma=COMPLEX * np.eye(2)),
        lambda: Blend(filters=(ALL_PASS,), weights=np.full((N, 1), 1j)),
        lambda: FiniteDifference(experiment=len, basis=np.full((N, 1), 1j)),
        lambda: QuadraticCriterion(error=COMPLEX, change=1.0),
        lambda: QuadraticCriterion(change=1.0, error_filter=COMPLEX),
        lambda: Constrained(T_u=SERVO, n_samples=2, limit=COMPLEX),
        lambda: BasisFunctions(T_u=SERVO, basis=np.full((N, 1, 1), 1j)),
        lambda: RationalBasis(T_u=SERVO, reference=np.full((N, 1), 1j)),
    ],
)
def test_complex_values_are_refused_and_not_cut(build):
    with pytest.raises(ValueError, match="must be real numbers, got complex128"):
        build()


@pytest.mark.parametrize(
    "build",
    [
        lambda: shift(np.zeros((N, 1)), 1.5),
        lambda: PType(delta=1.5),
        lambda: DType(gamma_d=0.1, sample_time=T_S, delta=1.5),
        lambda: MatrixGain(gamma=np.eye(2), delta=(1, 1.5)),
        lambda: heuristic_criterion(SERVO, 0.5, 1.5, LOW),
        lambda: heuristic_criterion(SERVO, 0.5, np.nan, LOW),
        lambda: PointToPoint(T_u=SERVO, points=[1.7], n_samples=N),
        lambda: PointToPoint(T_u=SERVO, points=[np.nan], n_samples=N),
        lambda: PointToPoint(T_u=SERVO, points=np.arange(N) == 5, n_samples=N),
        lambda: Repetitive(L=PType(), period=10.5),
        lambda: Repetitive(L=PType(), period=np.nan),
        lambda: Repetitive(L=PType(), period=10, begin=0.5),
    ],
)
def test_what_is_counted_in_samples_is_whole(build):
    with pytest.raises(ValueError, match="whole number of samples"):
        build()


def test_whole_numbers_of_any_type_are_samples():
    points = PointToPoint(T_u=SERVO, points=np.array([3.0, 5.0, 3.0, N - 1]), n_samples=N)
    known = PointToPoint(T_u=SERVO, points=[3, 5, N - 1], n_samples=N)
    e = np.ones((N, 1))
    assert np.array_equal(points(0.0 * e, e), known(0.0 * e, e))
    assert np.array_equal(PType(delta=np.float64(2.0))(e.cumsum(0)), PType(delta=2)(e.cumsum(0)))
    assert Repetitive(L=PType(), period=10.0, begin=2.0).laps(np.ones((10, 1)), N).shape == (N, 1)


def test_an_inverse_where_the_model_is_zero_is_refused():
    washout = System([1.0, -1.0], [1.0, -0.5], T_S)
    for beyond in Beyond:
        law = ModelInverse(T_u=washout, learned=LOW, beyond=beyond)
        with pytest.raises(ValueError, match="regularisation"):
            law(np.ones((N, 1)))
    assert np.isfinite(
        ModelInverse(T_u=washout, learned=LOW, regularisation=1e-6)(np.ones((N, 1)))
    ).all()


@pytest.mark.parametrize("shape", [(2, 2), (3, 2), (2, 3)])
def test_an_inverse_of_nearly_equal_columns_is_that_of_its_singular_values(shape):
    """Coupling of condition 1e6: the normal equations lose twelve digits."""
    rng = np.random.default_rng(3)
    U, V = (np.linalg.qr(rng.standard_normal((n, n)))[0] for n in shape)
    D = U[:, :2] @ np.diag([1.0, 1e-6]) @ V[:, :2].T
    T = StateSpace(0.5 * np.eye(len(D)), D, np.eye(len(D)), sample_time=T_S)
    omega = np.array([0.1, 0.5])
    found = ModelInverse(T_u=T, learned=ALL_PASS).response(omega)
    for L, w in zip(found, omega, strict=True):
        wanted = (V[:, :2] @ np.diag([1.0, 1e6]) @ U[:, :2].T) * (np.exp(1j * w) - 0.5)
        np.testing.assert_allclose(L, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())


def test_an_inverse_of_equal_columns_is_refused():
    T = StateSpace([[0.5]], [[1.0, 1.0]], [[1.0], [1.0]], sample_time=T_S)
    with pytest.raises(ValueError, match="no inverse"):
        ModelInverse(T_u=T, learned=LOW)(np.ones((N, 2)))
