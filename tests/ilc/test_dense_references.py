"""Filters, simulation, estimation and identification beside dense or scipy references.

Random cases: agree or refuse. CI tries ten times as many. Laws: test_dense_laws, analysis:
test_dense_analysis.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are
from scipy.signal import butter, lfilter, sosfilt, sosfiltfilt

from armside.ilc.estimation.extended import extended
from armside.ilc.estimation.kalman import Smoother, SteadyStateFilter
from armside.ilc.estimation.process import Process, steady_state_covariance
from armside.ilc.estimation.square_root import smooth_square_root
from armside.ilc.filters import Edge, ZeroPhaseButterworth
from armside.ilc.identification.arx import fit_arx
from armside.ilc.identification.first_order import fit_first_order
from armside.ilc.models.system import System

from .random_cases import AGREED, DAMPING, ORDER, SEED, SLOWEST, T_S, cases, random_system


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
    root: np.ndarray
    """S of the covariance S S^T at the start."""
    seen: np.ndarray
    y: np.ndarray

    @property
    def start(self):
        return self.root @ self.root.T


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
    return Gaussian(process, first, seen, y)


@pytest.mark.filterwarnings("ignore:variances of states and readings")  # it is right all the same
@cases(25)
@given(n=st.integers(1, 5), p=st.integers(1, 3), n_samples=st.integers(2, 25), seed=SEED)
def test_smoothers_are_the_mean_and_covariance_of_the_joint_gaussian(n, p, n_samples, seed):
    """By covariances, by square roots, and by the extended filter on a linear process."""
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
    shown: Any = given.seen.ravel()
    H = np.kron(np.eye(n_samples), C)[shown]
    S = H @ P @ H.T + np.kron(np.eye(n_samples), R)[np.ix_(shown, shown)]
    K = np.linalg.solve(S, H @ P).T
    smoother = Smoother(given.process, given.start, given.seen)
    found = smoother(given.y).smoothed.ravel()
    mean, scale = K @ given.y[given.seen], max(np.abs(P).max(), 1.0)
    np.testing.assert_allclose(found, mean, rtol=0, atol=AGREED * max(np.abs(mean).max(), 1.0))
    covariance = (P - K @ H @ P).reshape(n_samples, n, n_samples, n)
    of_roots = smooth_square_root(given.process, given.y, np.zeros(n), given.root)
    for i in range(n_samples):
        for P_i in (smoother.smoothed_covariance[i], of_roots.smoothed_covariance[i]):
            np.testing.assert_allclose(P_i, covariance[i, :, i], rtol=0, atol=1e-9 * scale)
    steps = (lambda i, x: (A @ x, A)), (lambda i, x: (C @ x, C))
    linear = extended(*steps, given.y, Q, R, np.zeros(n), given.start)
    for states in (of_roots.smoothed, linear.smoothed):
        off = np.abs(states.ravel() - mean).max()
        assert off <= AGREED * max(np.abs(mean).max(), 1.0)


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
    np.testing.assert_allclose(found.coefficients, expected, rtol=0, atol=AGREED * scale)
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
