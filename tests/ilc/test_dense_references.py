"""Every solver of the package beside a dense or scipy reference on random cases: agree or refuse.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4. A refusal is an error that says
so; a result that differs is a failure. CI tries ten times as many cases.
"""

import os
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are, toeplitz
from scipy.signal import butter, lfilter, sosfilt, sosfiltfilt

from armside.ilc.analysis import LiftedIteration, heuristic_criterion, largest_cutoff, largest_gamma
from armside.ilc.analysis.limits import largest_gain_factor
from armside.ilc.estimation.kalman import Smoother, SteadyStateFilter
from armside.ilc.estimation.process import Process, steady_state_covariance
from armside.ilc.filters import ALL_PASS, Edge, ZeroPhaseButterworth
from armside.ilc.identification.arx import fit_arx
from armside.ilc.identification.first_order import fit_first_order
from armside.ilc.laws import Heuristic
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

T_S = 0.004
AGREED = 1e-6
"""Largest difference from a reference, relative to the size of the reference."""


def cases(number):
    """Settings for so many examples: the same ones in every run, or many more in CI."""
    return settings(
        max_examples=number * (10 if os.environ.get("ARMSIDE_CI") else 1),
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.explicit, Phase.generate],
    )


SEED = st.integers(0, 10**6)
ORDER = st.integers(1, 14)
SLOWEST = st.sampled_from([0.7, 0.9, 0.97, 0.995])
DAMPING = st.sampled_from([0.5, 0.05, 5e-3, 1e-4])


def random_system(rng, order, slowest, damping):
    """Real poles below `slowest`, pairs with at least `damping`; the largest gain is about 1."""
    poles = []
    while len(poles) < order:
        if len(poles) + 2 <= order and rng.random() < 0.5:
            omega = rng.uniform(0.05, 2.8)
            pole = np.exp(omega * (-np.exp(rng.uniform(np.log(damping), 0.0)) + 1j))
            poles += [pole, pole.conjugate()]
        else:
            poles.append(rng.uniform(0.4, slowest))
    a = np.poly(poles).real
    b = np.concatenate((np.zeros(rng.integers(0, 4)), rng.standard_normal(order)))
    gain = np.abs(System(b, a, T_S).response(np.angle(poles))).max()
    return System(b / gain, a, T_S)


def random_matrix(rng, n, *shape):
    """A system, or a matrix of systems that all differ."""
    rows = tuple(tuple(random_system(rng, *shape) for _ in range(n)) for _ in range(n))
    return rows[0][0] if n == 1 else SystemMatrix(rows)


def entries_of(T):
    return T.entries if isinstance(T, SystemMatrix) else ((T,),)


def dense(T, n_samples, taps=(1.0,)):
    """F T by scipy's recursion, (N n, N n), samples first, motors within a sample."""
    entries = entries_of(T)
    n = len(entries)
    full = np.zeros((n_samples, n, n_samples, n))
    for i, row in enumerate(entries):
        for j, system in enumerate(row):
            h = lfilter(taps, [1.0], lfilter(system.b, system.a, np.eye(n_samples)[0]))
            full[:, i, :, j] = toeplitz(h, np.zeros(n_samples))
    return full.reshape(n_samples * n, n_samples * n)


def narrow_grid(T, *more):
    """Frequencies from 0 to pi that resolve each pole: evenly, and by decades about its angle."""
    poles = np.concatenate([*(s.poles for row in entries_of(T) for s in row), *more])
    grid = [np.linspace(0.0, np.pi, 4001), np.geomspace(1e-7, np.pi, 4001)]
    for pole in np.unique(poles.round(12)):
        width = max(abs(1.0 - abs(pole)), 1e-9)
        near = width * np.tan(np.linspace(-1.5707, 1.5707, 1201))
        grid.append(abs(np.angle(pole)) + near)
    omega = np.unique(np.concatenate(grid))
    return omega[(omega >= 0.0) & (omega <= np.pi)]


# Laws


@cases(8)
@given(
    shape=st.sampled_from([(1, 14), (2, 9), (3, 6), (4, 4), (5, 3), (6, 3)]),
    fraction=st.floats(0.0, 1.0),
    slowest=SLOWEST,
    damping=DAMPING,
    weight=st.sampled_from([1e-2, 1e-4, 1e-6]),
    varying=st.booleans(),
    taps=st.sampled_from([(1.0,), (1.0, -0.8)]),
    seed=SEED,
)
def test_a_norm_optimal_step_is_the_least_squares_solution(
    shape, fraction, slowest, damping, weight, varying, taps, seed
):
    rng = np.random.default_rng(seed)
    n, order = shape[0], max(1, round(fraction * shape[1]))
    n_samples = max(50, 300 // n)
    T = random_matrix(rng, n, order, slowest, damping)
    u, e = rng.standard_normal((2, n_samples, n))
    size = (n_samples, n) if varying else ()
    We, Wu, Wd = (np.exp(rng.uniform(-1, 1, size)) * w for w in (1.0, weight, 10 * weight))
    criterion = QuadraticCriterion(error=We, correction=Wu, change=Wd, error_filter=taps)
    try:
        law = NormOptimal(T_u=T, n_samples=n_samples, n_columns=n, criterion=criterion)
        ours = law(u, e)
    except (ValueError, RuntimeError) as refused:
        assert "is unstable" in str(refused) or "known to" in str(refused)  # noqa: PT017
        return
    We, Wu, Wd = (np.broadcast_to(w, (n_samples, n)).ravel() for w in (We, Wu, Wd))
    G = np.sqrt(We)[:, None] * dense(T, n_samples, taps)
    stacked = np.vstack((G, np.diag(np.sqrt(Wu)), np.diag(np.sqrt(Wd))))
    right = (np.sqrt(We) * lfilter(taps, [1.0], e, axis=0).ravel(), -np.sqrt(Wu) * u.ravel())
    step = np.linalg.lstsq(stacked, np.concatenate((*right, np.zeros(u.size))))[0]
    expected = u.ravel() + step
    assert np.linalg.norm(ours.ravel() - expected) <= AGREED * np.linalg.norm(expected)


# Analysis


@cases(10)
@given(
    n=st.sampled_from([1, 1, 1, 2, 3]),
    order=ORDER,
    slowest=SLOWEST,
    damping=DAMPING,
    gamma=st.floats(0.01, 2.0),
    delta=st.integers(-3, 12),
    cutoff=st.floats(1.0, 100.0),
    seed=SEED,
)
def test_the_criterion_is_the_supremum_over_frequencies(
    n, order, slowest, damping, gamma, delta, cutoff, seed
):
    """Singular values on a grid that resolves every resonance; nothing is above the bound."""
    T = random_matrix(np.random.default_rng(seed), n, order, slowest, damping)
    if not T.is_stable:
        return
    for Q in (ZeroPhaseButterworth(cutoff, T_S), ALL_PASS):
        found = heuristic_criterion(T, gamma, delta, Q)
        omega = narrow_grid(T, Q.poles, [np.exp(1j * found.limiting_omega) * (1.0 - 1e-9)])
        response = T.response(omega).reshape(-1, n, n)
        L = gamma * np.exp(1j * delta * omega)[:, None, None]
        gain = Q.response(omega) * np.linalg.norm(np.eye(n) - L * response, 2, axis=(1, 2))
        assert found.bound is not None
        # the response of a narrow resonance of high order is itself rounded to 1e-8
        assert gain.max() <= found.bound * (1 + AGREED)
        assert found.contraction == pytest.approx(gain.max(), rel=AGREED)
        assert found.is_met == (found.bound < 1.0)


@cases(20)
@given(order=ORDER, slowest=SLOWEST, damping=DAMPING, delta=st.integers(0, 8), seed=SEED)
def test_the_largest_gain_is_the_edge_of_the_criterion(order, slowest, damping, delta, seed):
    """Just below it the supremum over frequencies is below 1, just above it is not."""
    T = random_system(np.random.default_rng(seed), order, slowest, damping)
    if not T.is_stable:
        return
    cutoff = 10.0 ** np.random.default_rng(seed).uniform(0.0, 1.8)
    gamma = largest_gamma(T, [delta], [cutoff])[0, 0]
    Q = ZeroPhaseButterworth(cutoff, T_S)
    omega = narrow_grid(T, Q.poles)[1:]
    LT = np.exp(1j * delta * omega) * T.response(omega)

    def contraction(gain):
        return (Q.response(omega) * np.abs(1.0 - gain * LT)).max()

    if gamma > 1e-9:
        assert contraction(gamma * (1 - 1e-5)) <= 1.0 + 1e-9
    assert heuristic_criterion(T, (gamma + 1e-12) * (1 + 1e-5), delta, Q).bound >= 1.0
    edge = largest_cutoff(T, 0.5 * gamma, delta) if gamma > 1e-9 else np.inf
    if np.isfinite(edge) and edge < 120.0:
        assert edge >= cutoff * (1 - 1e-6)  # half the largest gain of this cutoff admits it
        above = ZeroPhaseButterworth(min(edge * (1 + 1e-4), 124.9), T_S)
        assert heuristic_criterion(T, 0.5 * gamma, delta, above).bound >= 1.0 - 1e-9


@cases(1)
@given(n=st.just(2), order=st.integers(1, 2), slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_the_largest_gain_of_coupled_motors_is_the_edge_of_the_criterion(
    n, order, slowest, damping, seed
):
    T = random_matrix(np.random.default_rng(seed), n, order, slowest, damping)
    Q = ZeroPhaseButterworth(10.0, T_S)
    factor = largest_gain_factor(T, 0.5, 3, Q)
    if factor > 0.0:
        assert heuristic_criterion(T, 0.5 * factor, 3, Q).is_met
    assert not heuristic_criterion(T, 0.5 * max(factor, 1e-6) * (1 + 1e-5), 3, Q).is_met


@cases(10)
@given(order=ORDER, slowest=SLOWEST, damping=DAMPING, power=st.sampled_from([1, 3, 40]), seed=SEED)
def test_growth_and_fixed_point_are_those_of_the_dense_iteration(
    order, slowest, damping, power, seed
):
    rng = np.random.default_rng(seed)
    n_samples = int(rng.integers(50, 150))
    T = random_system(rng, order, slowest, damping)
    if not T.is_stable:
        return
    Q = ZeroPhaseButterworth(20.0, T_S)
    law = Heuristic(Q=Q, gamma=0.3, delta=2)
    lifted = LiftedIteration.build(T, law, n_samples)
    sos = butter(2, 20.0, fs=1.0 / T_S, output="sos")
    identity = np.eye(n_samples)
    low = sosfiltfilt(sos, identity, axis=0, padtype="odd", padlen=6)
    ahead = np.minimum(np.arange(n_samples) + 2, n_samples - 1)
    dense_iteration = low @ (identity - 0.3 * identity[ahead] @ dense(T, n_samples))
    scale = np.linalg.norm(dense_iteration, 2)
    np.testing.assert_allclose(lifted.iteration, dense_iteration, rtol=0, atol=1e-9 * scale)
    expected = np.linalg.norm(np.linalg.matrix_power(dense_iteration, power), 2)
    assert lifted.transient_growth(power)[0] == pytest.approx(expected, rel=AGREED)
    e_0 = rng.standard_normal((n_samples, 1))
    u, limit = lifted.fixed_point(e_0)
    left = u - dense_iteration @ u - 0.3 * low @ e_0[ahead]
    assert np.abs(left).max() <= AGREED * max(np.abs(u).max(), 1.0)
    e_inf = e_0 - dense(T, n_samples) @ u
    np.testing.assert_allclose(limit, e_inf, atol=AGREED * np.abs(u).max() * scale)


# Filters


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


@cases(25)
@given(n=st.integers(1, 5), p=st.integers(1, 3), n_samples=st.integers(2, 25), seed=SEED)
def test_a_smoother_is_the_mean_and_covariance_of_the_joint_gaussian(n, p, n_samples, seed):
    given = random_process(np.random.default_rng(seed), n, p, n_samples)
    A, Q, C, R = (getattr(given.process, name) for name in "AQCR")
    T = np.zeros((n_samples, n, n_samples, n))
    for i in range(n_samples):
        for j in range(i + 1):
            T[i, :, j] = np.linalg.matrix_power(A, i - j)
    T = T.reshape(n_samples * n, n_samples * n)
    W = np.kron(np.eye(n_samples), Q)
    W[:n, :n] = given.start
    P, shown = T @ W @ T.T, given.seen.ravel()
    H = np.kron(np.eye(n_samples), C)[shown]
    S = H @ P @ H.T + np.kron(np.eye(n_samples), R)[np.ix_(shown, shown)]
    K = np.linalg.solve(S, H @ P).T
    smoother = Smoother(given.process, given.start, given.seen)
    found = smoother(given.y).smoothed.ravel()
    mean, scale = K @ given.y[given.seen], max(np.abs(P).max(), 1.0)
    np.testing.assert_allclose(found, mean, rtol=0, atol=AGREED * max(np.abs(mean).max(), 1.0))
    covariance = (P - K @ H @ P).reshape(n_samples, n, n_samples, n)
    for i in range(n_samples):
        np.testing.assert_allclose(
            smoother.smoothed_covariance[i], covariance[i, :, i], rtol=0, atol=1e-9 * scale
        )


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
    y = lfilter(T.b, T.a, u, axis=0)
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
        x = lfilter(np.append(np.zeros(delay), 1.0), [1.0, -candidate], u[:, 0])
        return np.square(y[:, 0] - x * (x @ y[:, 0]) / (x @ x)).sum()

    least = min(error(candidate) for candidate in np.arange(0.0, 0.981, 0.002))
    assert error(found.pole) <= least * (1 + 1e-3) + 1e-6 * np.square(y).sum()
    out_of_reach = not -0.01 <= pole <= 0.985
    if out_of_reach and noise < 0.1:
        assert any("end of the search" in text for text in found.warnings)
