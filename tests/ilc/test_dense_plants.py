"""Laws on state-space and time-varying plants beside dense least squares: agree or refuse.

One to six inputs, up to 14 states, poles to 0.995, damping to 1e-4.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from armside.ilc.laws.model_based import Gradient
from armside.ilc.laws.norm_optimal import Constrained, NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.state_space import StateSpace, TimeVarying

from .random_cases import (
    AGREED,
    DAMPING,
    ORDER,
    SEED,
    SLOWEST,
    T_S,
    cases,
    dense_states,
    random_state_matrix,
)

KIND = st.sampled_from(["state space", "time-varying"])


def random_matrices(rng, order, m, p, slowest, damping) -> Any:
    A = random_state_matrix(rng, order, slowest, damping)
    B, C = rng.standard_normal((order, m)), rng.standard_normal((p, order))
    D = rng.choice([0.0, 0.3]) * rng.standard_normal((p, m))
    gain = np.linalg.norm(C @ np.linalg.solve(np.eye(order) - A, B) + D, 2)
    return A, B, C / gain, D / gain


def along(rng, matrices, n_samples, drift=0.2) -> Any:
    """Matrices along the record, drifting by so much from their first values."""
    drawn = [rng.uniform(-drift, drift, M.shape) for M in matrices]
    drawn[0] *= 1e-2
    bend = np.sin(np.linspace(0.0, 3.0, n_samples))[:, None, None]
    return tuple(M + bend * change * M for M, change in zip(matrices, drawn, strict=True))


def random_plant(rng, kind, order, sizes, n_samples, slowest, damping) -> Any:
    """(model, (matrices along the record))."""
    fixed = random_matrices(rng, order, sizes[0], sizes[1], slowest, damping)
    repeated = tuple(np.broadcast_to(M, (n_samples, *M.shape)) for M in fixed)
    if kind == "state space":
        A, B, C, D = fixed
        return StateSpace(A, B, C, D, T_S), repeated
    varying = along(rng, fixed, n_samples)
    return TimeVarying(*varying), varying


@cases(8)
@given(
    kind=KIND,
    order=ORDER,
    sizes=st.sampled_from([(1, 1), (2, 2), (3, 2), (2, 3), (6, 6)]),
    slowest=SLOWEST,
    damping=DAMPING,
    weight=st.sampled_from([1e-1, 1e-3, 1e-5]),
    varying=st.booleans(),
    taps=st.sampled_from([(1.0,), (1.0, -0.8), (0.5, 0.2, -0.3)]),
    seed=SEED,
)
def test_a_step_on_any_plant_is_the_least_squares_solution(
    kind, order, sizes, slowest, damping, weight, varying, taps, seed
):
    rng = np.random.default_rng(seed)
    m, p = sizes
    n_samples = max(50, 200 // m)
    T_u, matrices = random_plant(rng, kind, order, sizes, n_samples, slowest, damping)
    u, e = rng.standard_normal((n_samples, m)), rng.standard_normal((n_samples, p))
    shapes = ((n_samples, p), (n_samples, m), (n_samples, m)) if varying else ((), (), ())
    factors = zip(shapes, (1.0, weight, 10 * weight), strict=True)
    We, Wu, Wd = (np.exp(rng.uniform(-1, 1, size)) * w for size, w in factors)
    criterion = QuadraticCriterion(error=We, correction=Wu, change=Wd, error_filter=taps)
    ours = NormOptimal(T_u=T_u, n_samples=n_samples, criterion=criterion)(u, e)
    We, Wu, Wd = (
        np.broadcast_to(w, (n_samples, k)).ravel() for w, k in ((We, p), (Wu, m), (Wd, m))
    )
    G = np.sqrt(We)[:, None] * dense_states(*matrices, taps=taps)
    F_e: Any = sum(
        f * np.vstack((np.zeros((k, p)), e[: n_samples - k])) for k, f in enumerate(taps)
    )
    stacked = np.vstack((G, np.diag(np.sqrt(Wu)), np.diag(np.sqrt(Wd))))
    right = (np.sqrt(We) * F_e.ravel(), -np.sqrt(Wu) * u.ravel(), np.zeros(u.size))
    expected = u.ravel() + np.linalg.lstsq(stacked, np.concatenate(right))[0]
    assert np.linalg.norm(ours.ravel() - expected) <= AGREED * np.linalg.norm(expected)


@cases(4)
@given(
    kind=KIND,
    order=st.integers(1, 6),
    sizes=st.sampled_from([(1, 1), (2, 2), (3, 2)]),
    seed=SEED,
)
def test_a_constrained_step_on_any_plant_is_the_bounded_least_squares_solution(
    kind, order, sizes, seed
):
    rng = np.random.default_rng(seed)
    m, p = sizes
    n_samples = 40
    T_u, matrices = random_plant(rng, kind, order, sizes, n_samples, 0.9, 0.05)
    e, zero = rng.standard_normal((n_samples, p)), np.zeros((n_samples, m))
    criterion = QuadraticCriterion(change=1e-2)
    law = Constrained(T_u=T_u, n_samples=n_samples, criterion=criterion, limit=0.5, tolerance=1e-8)
    stacked = np.vstack((dense_states(*matrices), 0.1 * np.eye(m * n_samples)))
    right = np.concatenate((e.ravel(), zero.ravel()))
    expected = lsq_linear(stacked, right, (-0.5, 0.5), tol=1e-14, max_iter=500)

    def cost(u):
        return 0.5 * np.square(stacked @ u - right).sum()

    assert cost(law(zero, e).ravel()) <= expected.cost * (1 + AGREED)
    assert np.abs(law(zero, e)).max() <= 0.5


@cases(8)
@given(
    kind=KIND,
    order=ORDER,
    sizes=st.sampled_from([(1, 1), (3, 2), (6, 6)]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_products_of_any_plant_are_those_of_its_matrix(kind, order, sizes, slowest, damping, seed):
    rng = np.random.default_rng(seed)
    (m, p), n_samples = sizes, 60
    T_u, matrices = random_plant(rng, kind, order, sizes, n_samples, slowest, damping)
    T = dense_states(*matrices)
    u, e = rng.standard_normal((n_samples, m)), rng.standard_normal((n_samples, p))
    scale = float(np.linalg.norm(T, 2))
    assert np.abs(T_u.simulate(u).ravel() - T @ u.ravel()).max() <= 1e-9 * scale
    assert np.abs(T_u.adjoint(e).ravel() - T.T @ e.ravel()).max() <= 1e-9 * scale
    if kind == "time-varying":
        step = Gradient(T_u=T_u).step
        assert step == pytest.approx(1.0 / scale**2, rel=AGREED)
    if kind == "state space":
        omega = np.array([0.0, 0.3, np.pi])
        A, B, C, D = (M[0] for M in matrices)
        z = np.exp(1j * omega)[:, None, None]
        expected = C @ np.linalg.solve(z * np.eye(order) - A, B + 0j * z) + D
        np.testing.assert_allclose(T_u.response(omega), expected, rtol=0, atol=1e-9 * scale)
