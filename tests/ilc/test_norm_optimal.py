"""Norm-optimal learning at the optimum, in linear time; random cases: test_dense_references."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion, QuadraticProblem
from armside.ilc.laws.riccati import Factored, factor
from armside.ilc.models.conversion import all_pass_states, realise
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

T_S = 0.004
AGREED = 1e-6
"""Largest difference from the dense solution, relative to it."""


def random_system(rng, order, low, high):
    """Poles with moduli in (low, high), half of them in pairs; largest gain 1."""
    poles = []
    while len(poles) < order:
        radius = rng.uniform(low, high)
        if len(poles) + 2 <= order and rng.random() < 0.5:
            pole = radius * np.exp(1j * rng.uniform(0.05, 2.8))
            poles += [pole, pole.conjugate()]
        else:
            poles.append(radius)
    a = np.poly(poles).real.astype(np.float64)
    b = np.concatenate(([0.0], rng.standard_normal(order)))
    omega = np.linspace(0.0, np.pi, 400)
    gain = np.abs(System(b, a, T_S).response(omega)).max()
    return System(b / gain, a, T_S)


def random_matrix(rng, n, order, low, high):
    return SystemMatrix(
        tuple(tuple(random_system(rng, order, low, high) for _ in range(n)) for _ in range(n))
    )


def dense(T, n_samples, taps=(1.0,)):
    """F T by scipy's recursion, (N n, N n), samples first, motors within a sample."""
    n = len(T.entries)
    full = np.zeros((n_samples, n, n_samples, n))
    impulse = np.eye(n_samples)[0]
    for i, row in enumerate(T.entries):
        for j, system in enumerate(row):
            h = lfilter(taps, [1.0], lfilter(system.b, system.a, impulse))
            full[:, i, :, j] = toeplitz(h, np.zeros(n_samples))
    return full.reshape(n_samples * n, n_samples * n)


def least_squares(G, F_e, u, We, Wu, Wd):
    """Minimum of |F_e - G d|^2_We + |u + d|^2_Wu + |d|^2_Wd, as u + d; all flat."""
    stacked = np.vstack((np.sqrt(We)[:, None] * G, np.diag(np.sqrt(Wu)), np.diag(np.sqrt(Wd))))
    right = np.concatenate((np.sqrt(We) * F_e, -np.sqrt(Wu) * u, np.zeros_like(u)))
    return u + np.linalg.lstsq(stacked, right)[0]


@pytest.mark.parametrize(
    ("n", "order", "low", "high", "n_samples"),
    [
        (6, 2, 0.7, 0.95, 100),
        (6, 3, 0.5, 0.9, 100),
        (4, 2, 0.9, 0.99, 150),
        (1, 12, 0.5, 0.97, 300),
    ],
)
def test_coupled_motors_with_entries_that_all_differ_are_solved(n, order, low, high, n_samples):
    """Products of denominators were off by factors of 1.4 to 1e7 in these cases."""
    rng = np.random.default_rng(1)
    T = random_matrix(rng, n, order, low, high)
    u, e = rng.standard_normal((2, n_samples, n))
    criterion = QuadraticCriterion(correction=1e-4, change=1e-2)
    ours = NormOptimal(T_u=T, n_samples=n_samples, n_columns=n, criterion=criterion)(u, e)
    weights = (np.full(u.size, w) for w in (1.0, 1e-4, 1e-2))
    expected = least_squares(dense(T, n_samples), e.ravel(), u.ravel(), *weights)
    assert np.linalg.norm(ours.ravel() - expected) <= AGREED * np.linalg.norm(expected)


def test_two_thousand_samples_of_six_motors_are_at_the_optimum():
    """H >= Wu + Wd, so |gradient|^2 / (2 (Wu + Wd)) bounds the cost above the optimum."""
    rng = np.random.default_rng(2)
    n, n_samples, Wu, Wd = 6, 2000, 1e-4, 1e-2
    T = random_matrix(rng, n, 2, 0.5, 0.99)
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
    one = realise(random_matrix(rng, n, 4, 0.5, 0.995), np.ones(1), n_samples)
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
