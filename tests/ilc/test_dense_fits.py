"""Polynomial and subspace fits beside scipy's least squares from the truth and exact responses.

Poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from enum import Enum
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


class Noise(Enum):
    """Noise of a model B / F u + v or A y = B u + v, and its orders."""

    ARMAX = "armax"
    OUTPUT_ERROR = "oe"
    BOX_JENKINS = "bj"

    def orders(self, order, nk):
        if self is Noise.ARMAX:
            return Orders.armax(order, order, 1, nk)
        if self is Noise.OUTPUT_ERROR:
            return Orders.output_error(order, order, nk)
        return Orders.box_jenkins(order, 1, 1, order, nk)

    @property
    def coefficients(self):
        """c and d of C / D e, or C e; their leading ones left out."""
        c, d = ([0.5], [-0.7])
        return {Noise.ARMAX: (c, []), Noise.OUTPUT_ERROR: ([], []), Noise.BOX_JENKINS: (c, d)}[self]


def prediction_errors(theta, order, noise, nk, u, y) -> Any:
    """A y = B u + C e, y = B / A u + e or B / A u + C / D e, by scipy's recursion."""
    sizes = np.cumsum([order, order, *map(len, noise.coefficients)])
    a, b, c, d, _ = np.split(theta, sizes)
    a, b, c, d = np.append(1.0, a), np.append(np.zeros(nk), b), np.append(1.0, c), np.append(1.0, d)
    with np.errstate(all="ignore"):
        if noise is Noise.ARMAX:
            left = lfilter(a, [1.0], y) - lfilter(b, [1.0], u)
        else:
            left = y - lfilter(b, a, u)
        e = lfilter(d, c, left)
    return np.nan_to_num(np.clip(e, -1e100, 1e100), nan=1e100)


def drawn(seed, order, noise, size, slowest, damping):
    """Record u, y (500,), its delay, and the true theta."""
    rng = np.random.default_rng(seed)
    T = random_system(rng, order, slowest, damping)
    nk = int(np.flatnonzero(T.b)[0])
    u = rng.standard_normal(500)
    y: Any = lfilter(T.b, T.a, u)
    c, d = noise.coefficients
    of_noise = T.a if noise is Noise.ARMAX else [1.0, *d]
    y = y + size * y.std() * lfilter([1.0, *c], of_noise, rng.standard_normal(500))
    return u, y, nk, np.concatenate((T.a[1:], T.b[nk:], c, d))


def fitted(order, noise, nk, u, y):
    """theta as `prediction_errors` takes it."""
    p = fit_polynomial(u[:, None], y[:, None], T_S, noise.orders(order, nk)).model.parts
    a = p["a" if noise is Noise.ARMAX else "f"]
    return np.concatenate((a[1:], p["b"][nk:], p["c"][1:], p["d"][1:]))


def least_from(theta, *about):
    """Minimum that scipy finds from there, and the sum of squares of it."""
    found = least_squares(prediction_errors, theta, args=about, x_scale="jac", xtol=1e-12)
    return found.x, 2.0 * found.cost


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
    kind = Noise.ARMAX if armax else Noise.OUTPUT_ERROR
    u, y, nk, truth = drawn(seed, order, kind, noise, slowest, damping)
    found = prediction_errors(fitted(order, kind, nk, u, y), order, kind, nk, u, y)
    assert np.square(found).sum() <= (1.0 + AGREED) * least_from(truth, order, kind, nk, u, y)[1]


@cases(4)
@given(
    order=st.integers(1, 4),
    size=st.sampled_from([0.01, 0.3]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_a_box_jenkins_fit_is_a_minimum_and_no_worse_than_the_truth(
    order, size, slowest, damping, seed
):
    """Scipy finds nothing better around it, but models whose dynamics are not stable. Of several
    minima it need not be the least."""
    about = order, Noise.BOX_JENKINS
    u, y, nk, truth = drawn(seed, *about, size, slowest, damping)
    theta = fitted(*about, nk, u, y)
    found, true = (np.square(prediction_errors(x, *about, nk, u, y)).sum() for x in (theta, truth))
    better, least = least_from(theta, *about, nk, u, y)
    stable = np.abs(np.roots(np.append(1.0, better[:order]))).max() < 1.0
    assert found <= true
    assert found <= (1.0 + AGREED) * least or not stable


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
