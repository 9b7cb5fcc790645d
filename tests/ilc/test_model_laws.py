"""Inverses of a model, norm-optimal learning and its limits, gradients with or without a model."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from armside.ilc import Heuristic, ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrder
from armside.ilc.laws.model_based import Gradient, ModelInverse
from armside.ilc.laws.model_free import FiniteDifference, b_splines
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion, QuadraticProblem
from armside.ilc.laws.riccati import Factored, factor
from armside.ilc.models.conversion import all_pass_states, realise
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix, largest_gain
from armside.ilc.models.two_mass import TwoMassPlant

from .random_cases import AGREED, random_matrix
from .signals import ARX, T_MOTOR, T_S, bump, error_norms

# Algorithm 2


def test_norm_optimal_responses_are_its_q_and_l_on_long_records():
    criterion = QuadraticCriterion(correction=1e-3, change=1e-2, error_filter=(1.0, -0.5))
    law = NormOptimal(T_u=ARX, n_samples=3000, n_columns=2, criterion=criterion)
    omega = 2 * np.pi * 12.0 * T_S
    t = np.arange(3000)
    sine = np.column_stack((np.cos(omega * t), np.sin(omega * t)))
    Q, L = (response[0] for response in law.responses(np.array([omega])))
    for u, e, expected in ((sine, 0 * sine, Q), (0 * sine, sine, Q * L)):
        got = law(u, e) @ [1, 1j]
        np.testing.assert_allclose(
            got[1000:2000], (expected * np.exp(1j * omega * t))[1000:2000], atol=1e-9
        )


def test_algorithms_2_and_3_beat_algorithm_1_on_the_two_mass_joint():
    plant = TwoMassPlant()
    Q = ZeroPhaseButterworth(17.0, 0.01)
    laws = {
        1: Heuristic(Q=Q, gamma=0.9, delta=5),
        2: FirstOrder(Q=Q, L=ModelInverse(T_u=T_MOTOR, learned=Q, regularisation=1e-6)),
        3: NormOptimal(
            T_u=T_MOTOR, n_samples=800, criterion=QuadraticCriterion(correction=1e-6, change=1e-4)
        ),
    }
    norms = {
        number: error_norms(plant, law, plant.motor_reference, 60, output_of=lambda run: run.motor)
        for number, law in laws.items()
    }
    to_5_percent = {i: int(np.argmax(values < 0.05 * values[0])) for i, values in norms.items()}
    assert to_5_percent[1] > 2 * to_5_percent[2] > 0
    assert to_5_percent[1] > 2 * to_5_percent[3] > 0
    assert norms[2][60] < norms[1][60]
    assert norms[3][60] < 0.1 * norms[1][60]


def test_two_thousand_samples_of_six_motors_are_at_the_optimum():
    """H >= Wu + Wd, so |gradient|^2 / (2 (Wu + Wd)) bounds the cost above the optimum."""
    rng = np.random.default_rng(2)
    n, n_samples, Wu, Wd = 6, 2000, 1e-4, 1e-2
    T = random_matrix(rng, n, 2, 0.99, 0.05)
    u, e = rng.standard_normal((2, n_samples, n))
    law = NormOptimal(
        T_u=T, n_samples=n_samples, n_columns=n,
        criterion=QuadraticCriterion(correction=Wu, change=Wd),
    )  # fmt: skip
    after = law(u, e)

    def through(entries, signal):
        columns = [
            np.sum([lfilter(s.b, s.a, signal[:, j]) for j, s in enumerate(row)], axis=0)
            for row in entries
        ]
        return np.stack(columns, axis=1)

    left = e - through(T.entries, after - u)
    back = through(tuple(zip(*T.entries, strict=True)), left[::-1])[::-1]
    gradient = Wu * after + Wd * (after - u) - back
    cost = np.sum(left**2) + Wu * np.sum(after**2) + Wd * np.sum((after - u) ** 2)
    assert np.sum(gradient**2) / (Wu + Wd) <= AGREED * cost


def test_a_diagonal_is_solved_motor_by_motor_and_constant_gains_are_kept_once():
    servo = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1, -0.4884]), T_S)
    slow = System(np.array([0, 0.1]), np.array([1, -0.9]), T_S)
    T = SystemMatrix.diagonal([servo, slow] * 3)

    def kept(n: int, change) -> int:
        criterion = QuadraticCriterion(correction=1e-4, change=change)
        problem = QuadraticProblem.build(T, criterion, n, 6)
        assert [columns for columns, _ in problem.parts] == [[i] for i in range(6)]
        gains = [part.gain for _, part in problem.parts if isinstance(part, Factored)]
        return sum(gain.size for gain in gains)

    # five states of each servo and one of each lag; weights that vary need each sample's gain
    assert kept(500, np.linspace(1e-2, 1e-3, 500)) == 500 * (3 * 5 + 3 * 1)
    assert kept(500, 1e-2) == kept(250, 1e-2) < 250 * (3 * 5 + 3 * 1)


@pytest.mark.parametrize("seed", range(3))
def test_gains_of_a_constant_model_are_those_of_its_riccati_recursion(seed):
    rng = np.random.default_rng(seed)
    n, n_samples = 3, 60
    one = realise(random_matrix(rng, n, 4, 0.995, 0.05), np.ones(1), n_samples)
    W, R = np.exp(rng.uniform(-2.0, 2.0, (2, 1, n))).repeat(n_samples, axis=1)
    alike = factor(one, W, R)
    W[0, 0] *= 1.0 + 1e-15  # no longer constant, so the recursion runs at each sample
    varying = factor(one, W, R)
    used = len(alike.L)
    np.testing.assert_allclose(alike.L, varying.L[:used], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(alike.gain, varying.gain[:used], rtol=1e-9, atol=1e-10)


def test_a_correction_without_effect_or_weight_is_refused():
    delayed = System(np.array([0, 0, 1.0]), np.array([1]), T_S)
    change = np.ones(40)
    change[-2:] = 0.0  # the last two samples of u reach no output
    with pytest.raises(ValueError, match="does not determine the correction"):
        NormOptimal(T_u=delayed, n_samples=40, criterion=QuadraticCriterion(change=change))


def test_a_step_that_the_model_contradicts_is_refused():
    """The check is against the model itself, not against the factors that gave the step."""
    true, other = (
        System(np.array([0, 1.0]), np.array([1, -0.5]), T_S),
        System(np.array([0, -1.0]), np.array([1, 0.9]), T_S),
    )
    criterion = QuadraticCriterion(change=1e-6)
    problem = QuadraticProblem.build(true, criterion, 50, 1)
    weights = np.ones((50, 1)), np.full((50, 1), 1e-6)
    wrong = factor(realise(SystemMatrix.diagonal([other]), np.ones(1), 50), *weights)
    problem.parts[0] = ([0], wrong)
    with pytest.raises(RuntimeError, match=r"norm-optimal step is known to .* of its size only"):
        problem.solve(np.random.default_rng(0).standard_normal((50, 1)))


def test_states_of_the_realisation_are_orthonormal_however_slow_the_poles():
    poles = np.concatenate((np.zeros(3), np.full(5, 0.995), [0.99 + 0.05j, 0.99 - 0.05j]))
    A, B = all_pass_states(poles)
    np.testing.assert_allclose(A @ A.T + np.outer(B, B), np.eye(10), atol=1e-14)
    # a pole of multiplicity 5 is known to eps^(1/5) of its place
    np.testing.assert_allclose(np.poly(A), np.poly(poles).real, atol=1e-11)


# Direct term, D-type, several motors


def test_a_direct_term_is_feedback_beside_the_learning():
    C = System([0.4, -0.2], [1, -0.5], T_S)
    reference = bump()
    plant = LinearPlant(T_u=ARX, reference=reference, C=C)
    plain = LinearPlant(T_u=ARX, reference=reference)
    u = 0.3 * bump()[::-1]
    y = plant.run(u)
    # the definition: the plant that is given u + C e in the same iteration returns the same y
    np.testing.assert_allclose(plain.run(u + C.simulate(reference - y)), y, atol=1e-12)


# Gradients with and without a model


def test_the_gradient_step_is_limited_by_the_largest_gain():
    # the norm of the lifted system approaches it from below as records grow
    T = toeplitz(T_MOTOR.impulse(800), np.zeros(800))
    assert 0.99 < np.linalg.norm(T, 2) / largest_gain(T_MOTOR) < 1.0
    with pytest.raises(ValueError, match=r"below 2/max\|T_u\|\^2"):
        Gradient(T_u=ARX, step=2.1 / largest_gain(ARX) ** 2)


def test_finite_differences_learn_a_plant_that_is_not_linear():
    reference = bump(200)

    class Saturating:
        def run(self, correction, /):
            return np.tanh(ARX.simulate(0.5 * reference + correction))

    plant = Saturating()
    goal = 0.5 * reference
    law = FiniteDifference(experiment=plant.run, basis=b_splines(200, 50))
    norms = error_norms(plant, law, goal, 5)
    assert norms[5] < 0.02 * norms[0]
