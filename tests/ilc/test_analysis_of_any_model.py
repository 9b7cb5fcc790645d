"""Finite-record analysis of models that vary, or are not square; laws that have none."""

import numpy as np
import pytest

from armside.ilc.analysis.record_iteration import LiftedIteration
from armside.ilc.filters import ALL_PASS
from armside.ilc.laws.first_order import PType
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.laws.memory import HighOrder
from armside.ilc.laws.norm_optimal import Constrained, NormOptimal
from armside.ilc.laws.transfer import RationalBasis
from armside.ilc.models.state_space import StateSpace, TimeVarying
from armside.ilc.models.system import System

N = 20
SERVO = System([0.0, 0.5], [1.0, -0.5], 0.01)
HALF = Heuristic(gamma=0.5, delta=1, Q=ALL_PASS)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def varying(rng: np.random.Generator, n: int = N) -> TimeVarying:
    shapes = (n, 3, 3), (n, 3, 1), (n, 1, 3)
    return TimeVarying(*(0.5 * rng.standard_normal(shape) for shape in shapes))


def markov(T: TimeVarying) -> np.ndarray:
    """Lifted matrix, C(t) A(t - 1) ... A(s + 1) B(s), written out."""
    G = np.zeros((N, N))
    for s in range(N):
        x = T.B[s]
        for t in range(s + 1, N):
            G[t, s] = (T.C[t] @ x)[0, 0]
            x = T.A[t] @ x
    return G


def test_the_lifted_iteration_of_a_varying_plant_is_that_of_its_matrix(rng):
    T = varying(rng)
    found, G = LiftedIteration.build(T, HALF, N), markov(T)
    shifted = np.eye(N, k=1)
    shifted[-1, -1] = 1.0
    np.testing.assert_allclose(found.T, G, rtol=1e-12, atol=1e-12)
    radius = np.abs(np.linalg.eigvals(np.eye(N) - 0.5 * shifted @ G)).max()
    np.testing.assert_allclose(found.spectral_radius, radius, rtol=1e-9)


def test_the_lifted_iteration_of_a_plant_that_is_not_square(rng):
    A, B, C = np.diag([0.5, 0.3]), rng.standard_normal((2, 3)), rng.standard_normal((2, 2))
    T = StateSpace(A, B, C)
    G = np.zeros((N, 2, N, 3))
    for t in range(N):
        for s in range(t):
            G[t, :, s] = C @ np.linalg.matrix_power(A, t - s - 1) @ B
    G = G.reshape(2 * N, 3 * N)
    found = LiftedIteration.build(T, NormOptimal(T_u=T, n_samples=N), N, 3)
    H = G.T @ G + (1e-4 + 1e-2) * np.eye(3 * N)
    wanted = np.eye(3 * N) - np.linalg.solve(H, G.T @ G + 1e-4 * np.eye(3 * N))
    np.testing.assert_allclose(found.T, G, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.iteration, wanted, atol=1e-8)
    e_0 = rng.standard_normal((N, 2))
    u, e = found.fixed_point(e_0)
    optimum = np.linalg.solve(G.T @ G + 1e-4 * np.eye(3 * N), G.T @ e_0.ravel())
    np.testing.assert_allclose(u.ravel(), optimum, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(e.ravel(), e_0.ravel() - G @ u.ravel(), atol=1e-9)


def test_a_law_with_limits_has_no_linear_iteration():
    law = Constrained(T_u=SERVO, n_samples=N, limit=1e-3)
    with pytest.raises(ValueError, match="limits"):
        LiftedIteration.build(SERVO, law, N)
    free, known = (
        LiftedIteration.build(SERVO, each(T_u=SERVO, n_samples=N), N)
        for each in (Constrained, NormOptimal)
    )
    assert free.contraction == pytest.approx(known.contraction, rel=1e-9)


def test_a_law_that_is_not_linear_has_no_lifted_iteration():
    r = np.sin(np.linspace(0.0, np.pi, N))[:, None] ** 4
    law = RationalBasis(T_u=SERVO, reference=r, n_numerator=1, n_denominator=1)
    with pytest.raises(ValueError, match="not linear"):
        LiftedIteration.build(SERVO, law, N)


def test_a_law_with_memory_has_no_first_order_iteration():
    law = HighOrder(L=PType(gamma=0.5, delta=1), alpha=(1.0, 0.0), beta=(1.0, -0.5))
    with pytest.raises(ValueError, match="memory"):
        LiftedIteration.build(SERVO, law, N)


@pytest.mark.parametrize("k", [100, 250, 400])
def test_a_power_that_no_number_holds_is_named(k):
    diverging = Heuristic(gamma=60.0, delta=1, Q=ALL_PASS)
    with pytest.raises(OverflowError, match=rf"power {k} of the map exceeds 1e\+150"):
        LiftedIteration.build(SERVO, diverging, 100).transient_growth(k)
