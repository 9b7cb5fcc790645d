"""Laws with a memory beside recursions written out, on random plants over five runs.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from scipy.stats import chi2

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrder, PType
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.laws.memory import (
    Adaptive,
    DisturbanceObserver,
    FrequencyKalman,
    HighOrder,
    internal_model,
    periodic_pattern,
)
from armside.ilc.laws.wrappers import Around, Guarded, Scheduled

from .dense_filters import LENGTH, LONGEST, MOTORS_AND_ORDER, by_column, low_pass, shifted, tapered
from .random_cases import AGREED, DAMPING, SEED, SLOWEST, T_S, cases, dense, random_matrix

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
@cases(2)
@given(shape=MOTORS_AND_ORDER, n_samples=LENGTH, slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_corrections_are_those_of_the_written_out_recursion(
    build, shape, n_samples, slowest, damping, seed
):
    rng, (n, order) = np.random.default_rng(seed), shape
    n_samples = min(n_samples, LONGEST // n)
    T = random_matrix(rng, n, order, slowest, damping)
    if not T.is_stable:
        return
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
        size = max(np.linalg.norm(expected), np.linalg.norm(us[-1]))
        assert np.linalg.norm(u.ravel() - expected) <= AGREED * size
