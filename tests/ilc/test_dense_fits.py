"""Polynomial and subspace fits beside scipy's least squares from the truth and exact responses.

Poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.signal import lfilter

from armside.ilc.identification.polynomial import Orders
from armside.ilc.identification.polynomial_fit import fit_polynomial
from armside.ilc.identification.subspace import fit_subspace

from .random_cases import (
    AGREED,
    DAMPING,
    SEED,
    SLOWEST,
    T_S,
    cases,
    random_state_matrix,
    random_system,
)


def prediction_errors(theta, order, armax, nk, u, y) -> Any:
    """A y = B u + C e with C of first order, or y = B / A u + e, by scipy's recursion."""
    a, b, c = np.split(theta, [order, 2 * order])
    a, b, c = np.append(1.0, a), np.append(np.zeros(nk), b), np.append(1.0, c)
    with np.errstate(all="ignore"):
        if armax:
            e = lfilter([1.0], c, lfilter(a, [1.0], y) - lfilter(b, [1.0], u))
        else:
            e = y - lfilter(b, a, u)
    return np.nan_to_num(np.clip(e, -1e100, 1e100), nan=1e100)


@cases(6)
@given(
    order=st.integers(1, 4),
    armax=st.booleans(),
    noise=st.sampled_from([0.01, 0.3]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_a_polynomial_fit_is_no_worse_than_least_squares_from_the_truth(
    order, armax, noise, slowest, damping, seed
):
    rng = np.random.default_rng(seed)
    T = random_system(rng, order, slowest, damping)
    nk = int(np.flatnonzero(T.b)[0])
    u = rng.standard_normal(500)
    y: Any = lfilter(T.b, T.a, u)
    c = [1.0, 0.5] if armax else [1.0]
    y = y + noise * y.std() * lfilter(c, T.a if armax else [1.0], rng.standard_normal(500))
    truth = np.concatenate((T.a[1:], T.b[nk:], c[1:]))
    least = least_squares(
        prediction_errors, truth, args=(order, armax, nk, u, y), x_scale="jac", xtol=1e-12
    )
    orders = Orders.armax(order, order, 1, nk) if armax else Orders.output_error(order, order, nk)
    p = fit_polynomial(u[:, None], y[:, None], T_S, orders).model.parts
    theta = np.concatenate((p["a" if armax else "f"][1:], p["b"][nk:], p["c"][1:]))
    found = prediction_errors(theta, order, armax, nk, u, y)
    assert np.square(found).sum() <= (1.0 + AGREED) * 2.0 * least.cost


@cases(5)
@given(
    order=st.integers(1, 14),
    m=st.integers(1, 2),
    p=st.integers(1, 3),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_a_subspace_fit_without_noise_has_the_response_of_the_truth(
    order, m, p, slowest, damping, seed
):
    """At the poles and elsewhere, relative to the largest response."""
    rng = np.random.default_rng(seed)
    A = random_state_matrix(rng, order, slowest, damping)
    B, C = rng.standard_normal((order, m)), rng.standard_normal((p, order))
    u, x = rng.standard_normal((500, m)), np.zeros(order)
    y = np.zeros((500, p))
    for i in range(500):
        y[i], x = C @ x, A @ x + B @ u[i]
    found = fit_subspace(u, y, T_S, order, horizon=order + 3)
    omega = np.concatenate((np.abs(np.angle(np.linalg.eigvals(A))), rng.uniform(0.0, np.pi, 20)))
    expected = np.array([C @ np.linalg.solve(np.exp(1j * w) * np.eye(order) - A, B) for w in omega])
    off = np.abs(found.model.response(omega) - expected).max()
    assert off <= AGREED * np.abs(expected).max()
