"""Laws beside their dense matrices, recursions written out and least squares, on random cases.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many. A
refusal is an error that says so; a result that differs is a failure.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter
from scipy.stats import chi2

from armside.ilc.filters import End, ZeroPhaseButterworth
from armside.ilc.laws.first_order import Blend, DType, FirstOrder, MatrixGain, PType
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.laws.memory import (
    Adaptive,
    DisturbanceObserver,
    FrequencyKalman,
    HighOrder,
    internal_model,
    periodic_pattern,
)
from armside.ilc.laws.model_based import Beyond, Gradient, ModelInverse
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.laws.robust import Matched
from armside.ilc.laws.wrappers import Around, BySegment, Guarded, JointSpace, Scheduled, Simulated

from .dense_filters import (
    by_column,
    largest_gain,
    low_pass,
    low_pass_gain,
    response,
    shifted,
    tapered,
)
from .random_cases import (
    DAMPING,
    LENGTH,
    LONGEST,
    MOTORS_AND_ORDER,
    SEED,
    SLOWEST,
    T_S,
    cases,
    close,
    dense,
    drawn,
    on_plants,
    random_matrix,
)


def p_type(rng, T, n, n_samples) -> Any:
    gamma, delta = rng.uniform(0.1, 1.0), int(rng.integers(-5, 20))
    return PType(gamma=gamma, delta=delta), by_column([gamma * shifted(n_samples, delta)] * n)


def d_type(rng, T, n, n_samples) -> Any:
    delta = int(rng.integers(-5, 20))
    change = shifted(n_samples, delta) - shifted(n_samples, delta - 1)
    return DType(gamma_d=0.01, sample_time=T_S, delta=delta), by_column([0.01 / T_S * change] * n)


def matrix_gain(rng, T, n, n_samples) -> Any:
    gamma, delta = rng.standard_normal((n, n)), tuple(rng.integers(-5, 20, n).tolist())
    full = np.einsum("ij,jts->tisj", gamma, [shifted(n_samples, d) for d in delta])
    return MatrixGain(gamma=gamma, delta=delta), full.reshape(n * n_samples, n * n_samples)


def gradient(rng, T, n, n_samples) -> Any:
    return Gradient(T_u=T), dense(T, n_samples).T / largest_gain(T) ** 2


def varying(rng, T, n, n_samples) -> Any:
    weights = rng.uniform(0.0, 1.0, (n_samples, 2))
    parts = ZeroPhaseButterworth(5.0, T_S), PType(gamma=0.4, delta=3)
    full = weights[:, :1] * low_pass(n_samples, 5.0)
    full = full + weights[:, 1:] * 0.4 * shifted(n_samples, 3)
    return Blend(filters=parts, weights=weights), by_column([full] * n)


def ahead(rng, T, n, n_samples) -> Any:
    taps, lead = rng.standard_normal(20), int(rng.integers(0, 20))
    full = sum(c * shifted(n_samples, lead - i) for i, c in enumerate(taps))
    return Matched(taps=taps, lead=lead, reached=0.0, least=0.0), by_column([full] * n)


FILTERS = p_type, d_type, matrix_gain, gradient, varying, ahead


@pytest.mark.parametrize("build", FILTERS, ids=lambda build: build.__name__)
@on_plants(3)
def test_an_update_is_that_of_its_matrices(build, case):
    rng, T, n, n_samples = case
    cutoffs = rng.uniform(1.0, 100.0, n)
    Q = by_column([low_pass(n_samples, f) for f in cutoffs])
    L, matrix = build(rng, T, n, n_samples)
    law = FirstOrder(L=L, Q=ZeroPhaseButterworth(tuple(cutoffs.tolist()), T_S))
    u, e = rng.standard_normal((2, n_samples, n))
    expected = Q @ (u.ravel() + matrix @ e.ravel())
    assert close(law(u, e).ravel(), expected)


@cases(5)
@given(n=st.integers(1, 6), n_samples=LENGTH, hold=st.booleans(), seed=SEED)
def test_a_heuristic_update_is_that_of_its_matrices(n, n_samples, hold, seed):
    """One gain, shift and cutoff a motor; on errors of the tool, through an inverse Jacobian."""
    rng, n_samples = np.random.default_rng(seed), min(n_samples, LONGEST // n)
    gamma, delta = rng.uniform(0.1, 1.5, n), rng.integers(-5, 20, n)
    cutoffs, J = rng.uniform(1.0, 100.0, n), rng.standard_normal((n, 3))
    law = Heuristic(
        Q=ZeroPhaseButterworth(tuple(cutoffs.tolist()), T_S),
        gamma=tuple(gamma.tolist()),
        delta=tuple(delta.tolist()),
        end=End.HOLD if hold else End.ZERO,
    )
    u, e = rng.standard_normal((n_samples, n)), rng.standard_normal((n_samples, 3))
    found = JointSpace(law=law, inverse=J)(u, e)
    for j in range(n):
        learned = gamma[j] * shifted(n_samples, delta[j], hold) @ (e @ J[j])
        expected = low_pass(n_samples, cutoffs[j]) @ (u[:, j] + learned)
        assert close(found[:, j], expected)


@cases(6)
@given(
    shape=MOTORS_AND_ORDER,
    n_samples=LENGTH,
    slowest=SLOWEST,
    damping=DAMPING,
    regularisation=st.sampled_from([1e-4, 1e-2]),
    beyond=st.sampled_from(list(Beyond)),
    seed=SEED,
)
def test_a_model_inverse_is_the_least_squares_solution_at_each_frequency(
    shape, n_samples, slowest, damping, regularisation, beyond, seed
):
    """min |T u - e|^2 + rho |u|^2 by scipy's response and ridge rows, then times 1 - H_B."""
    rng, T, n, stable = drawn(seed, shape, slowest, damping)
    n_samples = min(n_samples, LONGEST // n)
    if not stable:
        return
    learned = ZeroPhaseButterworth(20.0, T_S)
    L = ModelInverse(T_u=T, learned=learned, rate=0.8, regularisation=regularisation, beyond=beyond)
    e = rng.standard_normal((n_samples, n))
    whole = e
    if beyond is Beyond.TAPERED_HOLD:
        fade = 0.5 * (1.0 + np.cos(np.pi * np.arange(1, n_samples + 1) / (n_samples + 1)))[:, None]
        whole = np.vstack((e, fade * e[-1], fade[::-1] * e[0]))
    omega = 2.0 * np.pi * np.arange(len(whole)) / len(whole)
    G = response(T, omega)
    root = np.sqrt(regularisation) * largest_gain(T) * np.eye(n)
    E = np.fft.fft(whole, axis=0)
    U = [
        np.linalg.lstsq(np.vstack((g, root)), np.append(x, 0 * x))[0]
        for g, x in zip(G, E, strict=True)
    ]
    passed = 0.8 * low_pass_gain(omega, 20.0)[:, None]
    expected = np.fft.ifft(passed * np.array(U), axis=0).real[:n_samples]
    assert close(L(e), expected)


RUNS = 5
GAMMA, DELTA, CUTOFF = 0.4, 3, 20.0
L, Q = PType(gamma=GAMMA, delta=DELTA), ZeroPhaseButterworth(CUTOFF, T_S)


def filters(n_samples, n) -> Any:
    """Dense L and Q."""
    return (
        by_column([GAMMA * shifted(n_samples, DELTA)] * n),
        by_column([low_pass(n_samples, CUTOFF)] * n),
    )


def high_order(rng, T, e_0, shape) -> Any:
    alpha, beta = rng.uniform(-0.5, 1.0, (2, 3))
    M, F = filters(*shape)

    def update(us, es):
        past = list(zip(alpha, beta, us[::-1], es[::-1], strict=False))
        return F @ sum(a * u + b * (M @ e) for a, b, u, e in past)

    return HighOrder(alpha=tuple(alpha), beta=tuple(beta), L=L, Q=Q), update


def periodic(rng, T, e_0, shape) -> Any:
    """D(w) u = K(w) L e with D = 1 - w^3, K = (1 - p w)^3 - D."""
    pole = rng.uniform(0.0, 0.9)
    K = [-3.0 * pole, 3.0 * pole**2, 1.0 - pole**3]
    M, F = filters(*shape)

    def update(us, es):
        learned = sum(k * (M @ e) for k, e in zip(K, es[::-1], strict=False))
        return F @ (learned + (us[-3] if len(us) >= 3 else 0.0))

    return internal_model(periodic_pattern(3), L=L, Q=Q, pole=pole), update


def scheduled(rng, T, e_0, shape) -> Any:
    M, F = filters(*shape)
    gains = rng.uniform(0.1, 1.0, 3)
    each = (Heuristic(Q=Q, gamma=float(g), delta=DELTA) for g in gains)

    def update(us, es):
        return F @ (us[-1] + gains[min(len(us), 3) - 1] / GAMMA * (M @ es[-1]))

    return Scheduled(laws=tuple(each)), update


def around(rng, T, e_0, shape) -> Any:
    centre = rng.standard_normal(shape)
    M, F = filters(*shape)

    def update(us, es):
        return centre.ravel() + F @ (us[-1] - centre.ravel() + M @ es[-1])

    return Around(FirstOrder(L=L, Q=Q), centre), update


def guarded(rng, T, e_0, shape) -> Any:
    """Back to the best run, half the step for each that was a fifth worse; three end it."""
    M, F = filters(*shape)

    def update(us, es):
        best, gain, setbacks = 0, 1.0, 0
        for k in range(len(us)):
            sizes = np.linalg.norm(es[k]), np.linalg.norm(es[best])
            start = k
            if sizes[0] <= sizes[1]:
                best = k
            elif sizes[0] > 1.2 * sizes[1]:
                gain, setbacks, start = 0.5 * gain, setbacks + 1, best
        if setbacks >= 3:
            return us[best]
        return us[start] + gain * (F @ (us[start] + 4.0 * (M @ es[start])) - us[start])

    law = FirstOrder(L=PType(gamma=4.0 * GAMMA, delta=DELTA), Q=Q)
    return Guarded(law=law, weight=(1.0,) * shape[1]), update


def adaptive(rng, T, e_0, shape) -> Any:
    """P(t) of each sample and motor, raised where the power around it exceeds a chi2 quantile."""
    r_n, window = float(np.square(e_0).mean()) * rng.uniform(0.01, 0.5), 9
    M, F = filters(*shape)

    def update(us, es):
        P = np.full(shape, 2.0)
        for k, e in enumerate(es):
            squares = np.square(e.reshape(shape))
            for t in range(shape[0]) if k else ():
                near = squares[max(t - 4, 0) : t + 5]
                limit = chi2.ppf(1.0 - 1e-4, len(near)) / len(near)
                power = near.mean(axis=0)
                P[t] += np.where(power > limit * (P[t] + r_n), power - P[t] - r_n, 0.0)
            kappa = P / (P + r_n)
            P = P * r_n / (P + r_n)
        return F @ (us[-1] + kappa.ravel() * (M @ es[-1]))

    return Adaptive(L=L, Q=Q, noise_variance=r_n, initial_variance=2.0, window=window), update


def observer(rng, T, e_0, shape) -> Any:
    """An autoregression of second order over the runs, by least squares with ridge rows."""
    M, F = filters(*shape)
    G = dense(T, shape[0])

    def update(us, es):
        d = [e + G @ u for u, e in zip(us, es, strict=True)]
        if len(d) <= 2:
            return F @ (M @ d[-1])
        past = np.vstack([np.stack((d[k - 1], d[k - 2]), axis=1) for k in range(2, len(d))])
        root = np.sqrt(1e-6 * np.square(past).sum() / 2.0) * np.eye(2)
        c = np.linalg.lstsq(np.vstack((past, root)), np.concatenate((*d[2:], [0.0, 0.0])))[0]
        return F @ (M @ (c[0] * d[-1] + c[1] * d[-2]))

    return DisturbanceObserver(T_u=T, L=L, Q=Q), update


def kalman(rng, T, e_0, shape) -> Any:
    """Gain of each frequency by the variances of a scalar Kalman filter; the whole FFT."""
    M, _ = filters(*shape)
    R, W = 2.0 * shape[0] * np.square(rng.uniform(0.05, 0.5, 2))

    def update(us, es):
        E = [np.fft.fft(tapered(e.reshape(shape)), axis=0) for e in es]
        power = np.square(np.abs(E[0][: shape[0] + 1]))
        near = [power[max(i - 5, 0) : i + 6].mean(axis=0) for i in range(len(power))]
        P = np.maximum(np.array(near) - R, 0.0)
        for _ in es:
            kappa, P = P / (P + R), P * R / (P + R) + W
        both = np.vstack((kappa, kappa[-2:0:-1]))
        return us[-1] + M @ np.fft.ifft(both * E[-1], axis=0).real[: shape[0]].ravel()

    levels = np.sqrt(np.array([R, W]) / (2.0 * shape[0]))
    return FrequencyKalman(L=L, noise=levels[0], change=levels[1]), update


LAWS = high_order, periodic, scheduled, around, guarded, adaptive, observer, kalman


@pytest.mark.parametrize("build", LAWS, ids=lambda build: build.__name__)
@on_plants(2)
def test_corrections_are_those_of_the_written_out_recursion(build, case):
    rng, T, n, n_samples = case
    G, e_0 = dense(T, n_samples), rng.standard_normal((n_samples, n))
    law, update = build(rng, T, e_0, (n_samples, n))
    u, memory = np.zeros((n_samples, n)), None
    us, es = [], []
    for _ in range(RUNS):
        noise = 0.1 * rng.standard_normal(u.size)
        us.append(u.ravel().copy())
        es.append(e_0.ravel() - G @ us[-1] + noise)
        u, memory = law.step(u, es[-1].reshape(u.shape), memory)
        expected = update(us, es)
        assert close(u.ravel(), expected, np.linalg.norm(us[-1]))


LAW = FirstOrder(L=L, Q=Q)


def passes(G, e_0, u, unexplained, number):
    """Corrections and residuals of the passes on the simulated plant."""
    L, Q = filters(*e_0.shape)
    us = [u.ravel()]
    for _ in range(number):
        us.append(Q @ (us[-1] + L @ (e_0.ravel() - G @ us[-1] + unexplained)))
    return us, [(e_0.ravel() - G @ each + unexplained).reshape(u.shape) for each in us]


def last_pass(sizes):
    """The third running that is not 2 % smaller than the least before it, or the last of all."""
    fruitless = [k > 0 and sizes[k] >= 0.98 * min(sizes[:k]) for k in range(len(sizes))]
    ends = [k for k in range(2, len(sizes)) if all(fruitless[k - 2 : k + 1])]
    return ends[0] if ends else len(sizes) - 1


@on_plants(5, number=st.sampled_from([1, 4, 12, 30]))
def test_learning_on_a_simulation_is_that_of_its_matrices(number, case):
    """Passes u + L r, r with what the simulation leaves unexplained; the least residual is kept."""
    rng, T, n, n_samples = case
    e_0, u, e = rng.standard_normal((3, n_samples, n))
    weight, G = rng.uniform(0.5, 2.0, n), dense(T, n_samples)
    law = Simulated(
        simulation=lambda v: e_0 - T.simulate(v),
        law=LAW,
        Q_d=ZeroPhaseButterworth(40.0, T_S),
        weight=tuple(weight.tolist()),
        passes=number,
    )
    filtered = by_column([low_pass(n_samples, 40.0)] * n)
    unexplained = filtered @ (e.ravel() - e_0.ravel() + G @ u.ravel())
    us, residuals = passes(G, e_0, u, unexplained, number)
    sizes = [np.abs(r * weight).max() for r in residuals]
    kept = int(np.argmin(sizes[: last_pass(sizes) + 1]))
    assert close(law(u, e).ravel(), us[kept])


def last_of(sizes, least, patience):
    """Run after which a segment keeps its best correction, or None."""
    stalls = [k > 0 and sizes[k] > (1.0 - least) * min(sizes[:k]) for k in range(len(sizes))]
    ends = (k for k in range(1, len(sizes)) if all(stalls[max(k - patience + 1, 0) : k + 1]))
    return next(ends, None)


def blended(weight, sizes, us, least, patience) -> Any:
    """(N,) fraction that is kept, and the best corrections (N, n), after the last of the runs."""
    ends = [last_of(column, least, patience) for column in sizes.T]
    best = us[0]
    for k in range(1, len(us)):
        better = [
            sizes[k, i] < sizes[:k, i].min() and (end is None or k <= end)
            for i, end in enumerate(ends)
        ]
        new = np.diag(weight[:, better].sum(axis=1))
        best = new @ us[k] + (np.eye(len(new)) - new) @ best
    return weight[:, [end is not None for end in ends]].sum(axis=1), best


@on_plants(
    5,
    segments=st.integers(1, 5),
    patience=st.integers(1, 3),
    least=st.sampled_from([0.02, 0.1, 0.4]),
)
def test_learning_by_segment_is_that_of_its_matrices(segments, patience, least, case):
    """Eight runs; segments that stall keep their best correction, the others learn on."""
    rng, T, n, n_samples = case
    edges = np.linspace(0, n_samples, segments + 1).astype(int)
    centres = 0.5 * (edges[1:] + edges[:-1])
    weight = np.stack([np.interp(range(n_samples), centres, i) for i in np.eye(segments)], axis=1)
    judged = tuple(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))
    law = BySegment(
        law=LAW,
        weight=weight,
        judged=judged,
        size_of=lambda e: np.abs(e).max(axis=1),
        least=least,
        patience=patience,
    )
    (L, Q), G = filters(n_samples, n), dense(T, n_samples)
    e_0 = by_column([low_pass(n_samples, 10.0)] * n) @ rng.standard_normal(n * n_samples)
    u, memory = np.zeros((n_samples, n)), None
    us, sizes = [], []
    for _ in range(8):
        e = e_0 - G @ u.ravel() + 0.01 * rng.standard_normal(u.size)
        us.append(u)
        largest = np.abs(e.reshape(u.shape)).max(axis=1)
        sizes.append([np.sqrt(np.square(largest[i:j]).sum()) for i, j in judged])
        kept, best = blended(weight, np.array(sizes), us, least, patience)
        learned = (Q @ (u.ravel() + L @ e)).reshape(u.shape)
        expected = np.diag(1.0 - kept) @ learned + np.diag(kept) @ best
        u, memory = law.step(u, e.reshape(u.shape), memory)
        assert close(u, expected, np.linalg.norm(us[-1]))


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
    F_e: Any = lfilter(taps, [1.0], e, axis=0)
    right = (np.sqrt(We) * F_e.ravel(), -np.sqrt(Wu) * u.ravel())
    step = np.linalg.lstsq(stacked, np.concatenate((*right, np.zeros(u.size))))[0]
    expected = u.ravel() + step
    assert close(ours.ravel(), expected)
