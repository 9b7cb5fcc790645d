"""Fits and filters of states beside least squares and joint Gaussians, on random cases.

CI tries ten times as many.
"""

from enum import Enum
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are
from scipy.optimize import least_squares
from scipy.signal import butter, lfilter, sosfilt, sosfiltfilt

from armside.ilc.estimation.kalman import Smoother, SteadyStateFilter
from armside.ilc.estimation.process import Process, steady_state_covariance
from armside.ilc.filters import Edge, ZeroPhaseButterworth
from armside.ilc.identification.arx import fit_arx
from armside.ilc.identification.first_order_lag import fit_first_order
from armside.ilc.identification.polynomial import Orders
from armside.ilc.identification.polynomial_fit import fit_polynomial
from armside.ilc.identification.subspace import fit_subspace
from armside.ilc.models.system import System

from .random_cases import (
    AGREED,
    DAMPING,
    ORDER,
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


@cases(30)
@given(
    n_samples=st.sampled_from([50, 51, 300, 2000]),
    order=st.integers(1, 4),
    relative=st.sampled_from([1e-4, 1e-2, 0.1, 0.5, 0.99]),
    edge=st.sampled_from(list(Edge)),
    seed=SEED,
)
def test_a_zero_phase_filter_is_that_of_scipy(n_samples, order, relative, edge, seed):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.standard_normal((n_samples, 2)), axis=0)
    ours = ZeroPhaseButterworth(relative * 125.0, T_S, order, edge)
    sos = butter(order, relative, output="sos")
    if edge is Edge.ODD:
        expected = sosfiltfilt(sos, x, axis=0, padtype="odd", padlen=3 * order)
    else:
        ringing = np.zeros((int(40.0 / min(relative, 1.0 - relative)), 2))
        forwards = sosfilt(sos, np.vstack((x, ringing)), axis=0)
        expected = sosfilt(sos, forwards[::-1], axis=0)[::-1][:n_samples]
    np.testing.assert_allclose(ours(x), expected, rtol=0, atol=AGREED * np.abs(x).max())


@cases(20)
@given(order=ORDER, slowest=SLOWEST, damping=DAMPING, n_samples=st.integers(50, 2000), seed=SEED)
def test_a_simulation_is_that_of_scipy(order, slowest, damping, n_samples, seed):
    rng = np.random.default_rng(seed)
    T, u = random_system(rng, order, slowest, damping), rng.standard_normal((n_samples, 3))
    expected = lfilter(T.b, T.a, u, axis=0)
    assert np.abs(T.simulate(u) - expected).max() <= AGREED * np.abs(expected).max()


# Estimation


class Gaussian(NamedTuple):
    """A process with its record, some states known exactly, some without noise, some growing."""

    process: Process
    start: np.ndarray
    """(n, n), covariance."""
    seen: np.ndarray
    y: np.ndarray


def random_process(rng, n, p, n_samples):
    A = rng.standard_normal((n, n))
    A *= rng.choice([0.5, 0.95, 0.999, 1.05]) / np.abs(np.linalg.eigvals(A)).max()
    noise, first = (rng.standard_normal((n, n)) * (rng.random(n) < 0.6) for _ in range(2))
    reading = rng.standard_normal((p, p)) + 2.0 * np.eye(p)
    process = Process(
        A=A, Q=noise @ noise.T, C=rng.standard_normal((p, n)), R=0.1 * reading @ reading.T
    )
    seen = rng.random((n_samples, p)) < 0.8
    y = np.where(seen, rng.standard_normal((n_samples, p)), np.nan)
    return Gaussian(process, first @ first.T, seen, y)


@pytest.mark.filterwarnings("ignore:variances of states and readings")  # it is right all the same
@cases(25)
@given(n=st.integers(1, 5), p=st.integers(1, 3), n_samples=st.integers(2, 25), seed=SEED)
def test_smoothers_are_the_mean_and_covariance_of_the_joint_gaussian(n, p, n_samples, seed):
    """Given the whole record; filtered, given the rows up to each; innovations, those before it."""
    given = random_process(np.random.default_rng(seed), n, p, n_samples)
    A, Q, C, R = (getattr(given.process, name) for name in "AQCR")
    T = np.zeros((n_samples, n, n_samples, n))
    for i in range(n_samples):
        for j in range(i + 1):
            T[i, :, j] = np.linalg.matrix_power(A, i - j)
    T = T.reshape(n_samples * n, n_samples * n)
    W = np.kron(np.eye(n_samples), Q)
    W[:n, :n] = given.start
    P: Any = T @ W @ T.T

    def known(rows) -> Any:
        """Means (N, n) and covariances of the states, given so many rows."""
        shown = given.seen[:rows].ravel()
        H = np.kron(np.eye(n_samples)[:rows], C)[shown]
        S = H @ P @ H.T + np.kron(np.eye(rows), R)[np.ix_(shown, shown)]
        K = np.linalg.solve(S, H @ P).T
        mean = K @ given.y[:rows][given.seen[:rows]]
        return mean.reshape(n_samples, n), (P - K @ H @ P).reshape(n_samples, n, n_samples, n)

    smoother = Smoother(given.process, given.start, given.seen)
    result = smoother(given.y)
    mean, covariance = known(n_samples)
    largest, scale = max(np.abs(mean).max(), 1.0), max(np.abs(P).max(), 1.0)
    close = {"rtol": 0.0, "atol": AGREED * largest}
    np.testing.assert_allclose(result.smoothed, mean, **close)
    for i in range(n_samples):
        np.testing.assert_allclose(
            smoother.smoothed_covariance[i], covariance[i, :, i], rtol=0, atol=1e-9 * scale
        )
        (before, _), (after, spread) = known(i), known(i + 1)
        np.testing.assert_allclose(result.filtered[i], after[i], **close)
        np.testing.assert_allclose(
            smoother.filtered_covariance[i], spread[i, :, i], rtol=0, atol=1e-9 * scale
        )
        expected = np.where(given.seen[i], given.y[i] - C @ before[i], np.nan)
        np.testing.assert_allclose(result.innovation[i], expected, **close)


@cases(40)
@given(n=st.integers(1, 6), p=st.integers(1, 3), seed=SEED)
def test_a_steady_filter_is_the_stabilising_solution_of_the_riccati_equation(n, p, seed):
    one = random_process(np.random.default_rng(seed), n, p, 2).process
    try:
        P = steady_state_covariance(one)
    except RuntimeError as refused:
        assert "no steady state" in str(refused)  # noqa: PT017
        return
    expected = solve_discrete_are(one.A.T, one.C.T, one.Q, one.R)
    np.testing.assert_allclose(P, expected, rtol=0, atol=AGREED * np.abs(expected).max() + 1e-12)
    steady = SteadyStateFilter(one)
    assert np.abs(np.linalg.eigvals(one.A - one.A @ steady.gain @ one.C)).max() < 1.0


# Identification


@cases(20)
@given(
    na=st.integers(0, 5),
    nb=st.integers(1, 4),
    nk=st.integers(0, 6),
    n_samples=st.integers(50, 2000),
    m=st.integers(1, 3),
    slowest=SLOWEST,
    seed=SEED,
)
def test_an_arx_fit_is_the_least_squares_solution(na, nb, nk, n_samples, m, slowest, seed):
    rng = np.random.default_rng(seed)
    u = np.cumsum(rng.standard_normal((n_samples, m)), axis=0)
    T = random_system(rng, 2, slowest, 0.05)
    y: Any = lfilter(T.b, T.a, u, axis=0)
    y += rng.standard_normal(y.shape) * 10.0 ** rng.uniform(-4, 0) * y.std()
    try:
        found = fit_arx(u, y, T_S, na=na, nb=nb, nk=nk)
    except ValueError as refused:
        assert "do not excite" in str(refused)  # noqa: PT017
        return
    first = max(na, nk + nb - 1)
    rows = [
        [*(-y[t - i, j] for i in range(1, na + 1)), *(u[t - nk - i, j] for i in range(nb))]
        for t in range(first, n_samples)
        for j in range(m)
    ]
    X, target = np.array(rows), y[first:].ravel()
    Q, R = np.linalg.qr(X)
    expected = np.linalg.solve(R, Q.T @ target)
    left = target - X @ expected
    inverse = np.linalg.inv(R)
    covariance = left @ left / (len(X) - na - nb) * inverse @ inverse.T
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found.model.theta, expected, rtol=0, atol=AGREED * scale)
    scale = np.abs(covariance).max()
    np.testing.assert_allclose(found.covariance, covariance, rtol=0, atol=AGREED * scale)


@cases(8)
@given(
    pole=st.floats(-0.5, 0.999),
    delay=st.integers(0, 8),
    noise=st.sampled_from([0.0, 0.01, 0.3]),
    n_samples=st.sampled_from([100, 400, 1500]),
    seed=SEED,
)
def test_an_output_error_fit_is_the_least_of_all_poles_or_is_said(
    pole, delay, noise, n_samples, seed
):
    """Beside all poles in steps of 0.002; a pole out of reach comes with a warning."""
    rng = np.random.default_rng(seed)
    u = np.cumsum(rng.standard_normal((n_samples, 1)), axis=0)
    true = System(np.append(np.zeros(delay), 1.0 - pole), np.array([1.0, -pole]), T_S)
    y = true.simulate(u)
    y = y + noise * y.std() * rng.standard_normal(y.shape)
    found = fit_first_order(u, y, T_S, delays=[delay])

    def error(candidate):
        x: Any = lfilter(np.append(np.zeros(delay), 1.0), [1.0, -candidate], u[:, 0])
        return np.square(y[:, 0] - x * (x @ y[:, 0]) / (x @ x)).sum()

    least = min(error(candidate) for candidate in np.arange(0.0, 0.981, 0.002))
    assert error(found.pole) <= least * (1 + 1e-3) + 1e-6 * np.square(y).sum()
    out_of_reach = not -0.01 <= pole <= 0.985
    if out_of_reach and noise < 0.1:
        assert any("end of the search" in text for text in found.warnings)
