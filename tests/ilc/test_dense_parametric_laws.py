"""Laws with parameters, points, laps or weights over frequency beside dense least squares.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from armside.ilc.filters import Edge, ZeroPhaseButterworth
from armside.ilc.identification.impulse_response import DECAYS, Sums, impulse_response
from armside.ilc.laws.first_order import PType
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse
from armside.ilc.laws.model_free import FiniteDifference, MeasuredGradient, b_splines
from armside.ilc.laws.norm_optimal import PointToPoint, RecordOptimal
from armside.ilc.laws.repetitive import Repetitive
from armside.ilc.laws.transfer import BasisFunctions, across, derivatives

from .dense_filters import MOTORS_AND_ORDER, by_column, low_pass, response, shifted, tapered
from .random_cases import (
    AGREED,
    DAMPING,
    SEED,
    SLOWEST,
    T_S,
    cases,
    dense,
    random_matrix,
    random_system,
)

LENGTH = st.sampled_from([50, 51, 120])


def drawn(seed, shape, *poles) -> Any:
    rng = np.random.default_rng(seed)
    T = random_matrix(rng, *shape, *poles)
    return rng, T, shape[0], T.is_stable


def smooth(rng, n_samples, n):
    """A random walk twice summed, at rest at its start."""
    return low_pass(n_samples, 15.0) @ np.cumsum(rng.standard_normal((n_samples, n)), axis=0)


def close(found, expected, size=0.0):
    return np.linalg.norm(found - expected) <= AGREED * max(np.linalg.norm(expected), size)


@cases(8)
@given(shape=MOTORS_AND_ORDER, n_samples=LENGTH, slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_a_step_in_basis_functions_is_the_least_squares_solution(
    shape, n_samples, slowest, damping, seed
):
    """Augmented by the ridge; the basis of all motors' derivatives, scaled to unit mean square."""
    rng, T, n, stable = drawn(seed, shape, slowest, damping)
    if not stable:
        return
    r = smooth(rng, n_samples, n)
    basis = across(derivatives(r, T_S, 3))
    law = BasisFunctions(T_u=T, basis=basis, ridge=1e-6)
    theta = rng.standard_normal((n, 3 * n)) / np.sqrt(np.square(basis).mean(axis=0))
    u, e = np.einsum("tnp,np->tn", basis, theta), rng.standard_normal((n_samples, n))
    Psi = np.zeros((n_samples, n, n, 3 * n))
    for j in range(n):
        Psi[:, j, j] = basis[:, j]
    Psi = Psi.reshape(n_samples * n, -1)
    A = dense(T, n_samples) @ Psi
    size = np.sqrt(np.square(A).mean(axis=0))
    ridge = np.sqrt(1e-6 * len(A)) * np.eye(A.shape[1])
    right = np.append(e.ravel(), np.zeros(A.shape[1]))
    change = np.linalg.lstsq(np.vstack((A / size, ridge)), right)[0] / size
    assert close(law(u, e).ravel(), u.ravel() + Psi @ change)


@cases(6)
@given(
    shape=st.sampled_from([(1, 1), (1, 9), (2, 4)]),
    n_samples=LENGTH,
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_laws_that_measure_take_the_steps_of_the_dense_plant(
    shape, n_samples, slowest, damping, seed
):
    """The gradient by time reversal with its best step; Gauss-Newton on B-splines."""
    rng, T, n, stable = drawn(seed, shape, slowest, damping)
    if not stable:
        return
    G, (u, e) = dense(T, n_samples), rng.standard_normal((2, n_samples, n))
    law = MeasuredGradient(experiment=T.simulate, coupled=n > 1)
    g = G.T @ e.ravel()
    expected = u.ravel() + (G @ g) @ e.ravel() / np.square(G @ g).sum() * g
    assert close(law(u, e).ravel(), expected)
    knots = np.concatenate((np.zeros(3), np.linspace(0.0, 1.0, 5), np.ones(3)))
    x = np.linspace(0.0, 1.0, n_samples)
    B = np.stack([BSpline(knots, row, 3)(x) for row in np.eye(7)], axis=1)
    law = FiniteDifference(experiment=T.simulate, basis=b_splines(n_samples, 7), damping=1e-6)
    J = (G.reshape(n_samples * n, n_samples, n).swapaxes(1, 2) @ B).reshape(n_samples * n, -1)
    root = np.sqrt(1e-6 * np.square(J).sum(axis=0).max()) * np.eye(7 * n)
    c = np.linalg.lstsq(np.vstack((J, root)), np.append(e.ravel(), np.zeros(7 * n)))[0]
    assert close(law(u, e), u + B @ c.reshape(n, 7).T)


@cases(6)
@given(shape=MOTORS_AND_ORDER, n_samples=LENGTH, slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_a_point_to_point_step_is_the_least_squares_solution(
    shape, n_samples, slowest, damping, seed
):
    rng, T, n, stable = drawn(seed, shape, slowest, damping)
    if not stable:
        return
    points = np.sort(rng.choice(n_samples, 5, replace=False))
    try:
        law = PointToPoint(T_u=T, points=points.tolist(), n_samples=n_samples, n_columns=n)
        u, e = rng.standard_normal((2, n_samples, n))
        found = law(u, e)
    except RuntimeError as refused:
        assert "known to" in str(refused)  # noqa: PT017
        return
    G = dense(T, n_samples).reshape(n_samples, n, -1)[points].reshape(5 * n, -1)
    one = np.eye(n * n_samples)
    stacked = np.vstack((G, 1e-3 * one, 1e-2 * one))
    right = np.concatenate((e[points].ravel(), -1e-3 * u.ravel(), 0.0 * u.ravel()))
    assert close(found.ravel(), u.ravel() + np.linalg.lstsq(stacked, right)[0])


@cases(5)
@given(n=st.integers(1, 6), period=st.integers(40, 90), begin=st.integers(0, 30), seed=SEED)
def test_a_lap_is_corrected_by_the_mean_of_the_laps(n, period, begin, seed):
    """Three laps filtered one after another; the middle one counts."""
    rng, laps = np.random.default_rng(seed), 4
    n_samples = begin + laps * period + int(rng.integers(0, 10))
    u, e = rng.standard_normal((2, n_samples, n))
    law = Repetitive(
        L=PType(gamma=0.5, delta=3), Q=ZeroPhaseButterworth(20.0, T_S), period=period, begin=begin
    )
    triple = np.tile(np.eye(period), (3, 1))
    middle = slice(period, 2 * period)
    Q = (low_pass(3 * period, 20.0) @ triple)[middle]
    L = 0.5 * (shifted(3 * period, 3) @ triple)[middle]
    mean = [
        sum(x[begin + k * period : begin + (k + 1) * period] for k in range(1, laps)) / (laps - 1)
        for x in (u, e)
    ]
    lap = Q @ (mean[0] + L @ mean[1])
    at = (np.arange(n_samples) - begin) % period
    fade = np.minimum(1.0, np.arange(1, n_samples + 1) / (begin + 1))
    assert close(law(u, e), fade[:, None] * lap[at])


@cases(6)
@given(
    shape=st.sampled_from([(1, 1), (1, 14), (2, 4), (6, 1)]),
    n_samples=LENGTH,
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_a_regularised_inverse_is_that_of_the_whole_transform(
    shape, n_samples, slowest, damping, seed
):
    """One place, and two whose weights fade from one to the other."""
    rng, T, n, stable = drawn(seed, shape, slowest, damping)
    if not stable:
        return
    sizes, weights = rng.uniform(0.5, 2.0, (2, n))
    given = {"sample_time": T_S, "cutoff": 25.0, "gamma": 0.7, "regularisation": 0.02}
    given |= {"output_weight": tuple(weights), "input_size": tuple(sizes)}
    places = [RegularisedInverse(G=Matrix(T, scale), **given) for scale in (1.0, 1.5)]
    u, e = rng.standard_normal((2, n_samples, n))
    omega = 2.0 * np.pi * np.arange(2 * n_samples) / (2 * n_samples)
    folded = np.minimum(omega, 2.0 * np.pi - omega)
    Q = (1.0 / (1.0 + (folded / (2.0 * np.pi * T_S) / 25.0) ** 8))[:, None]
    E = np.fft.fft(tapered(e), axis=0)

    def learned(scale, passed):
        G = scale * weights[:, None] * response(T, omega) * sizes
        root = np.sqrt(0.02) * np.linalg.norm(G[0], 2) * np.eye(n)
        each = [
            np.linalg.lstsq(np.vstack((g, root)), np.append(weights * x, 0 * x))[0]
            for g, x in zip(G, E, strict=True)
        ]
        spectrum = passed * sizes * np.array(each)
        return np.fft.ifft(spectrum, axis=0).real[:n_samples]

    def filtered(x):
        return np.fft.ifft(Q * np.fft.fft(tapered(x), axis=0), axis=0).real[:n_samples]

    first = np.fft.fft(tapered(u), axis=0)
    whole = np.fft.ifft(Q * first, axis=0).real[:n_samples] + 0.7 * learned(1.0, Q)
    assert close(places[0](u, e), whole)
    fade = np.linspace(1.0, 0.0, n_samples)[:, None]
    law = ScheduledInverse(laws=tuple(places), weights=np.hstack((fade, 1.0 - fade)))
    both = fade * learned(1.0, Q > 1e-3) + (1.0 - fade) * learned(1.5, Q > 1e-3)
    assert close(law(u, e), filtered(u + 0.7 * both))


class Matrix:
    """Response (M, n, n) of a system or a matrix of systems, times a scale."""

    def __init__(self, T, scale=1.0):
        self.T, self.scale = T, scale

    def response(self, omega):
        return self.scale * response(self.T, np.asarray(omega))


@cases(4)
@given(
    shape=st.sampled_from([(1, 1), (1, 4), (2, 2), (3, 1)]),
    n_samples=st.sampled_from([50, 80]),
    damping=st.sampled_from([0.5, 0.05]),
    seed=SEED,
)
def test_a_record_optimal_step_is_the_least_squares_solution(shape, n_samples, damping, seed):
    """Impulse responses wrap around at twice the record, which its poles leave at 1e-9."""
    rng, T, n, stable = drawn(seed, shape, 0.7, damping)
    if not stable:
        return
    sizes, weights = rng.uniform(0.5, 2.0, (2, n))
    law = RecordOptimal(
        G=Matrix(T),
        F=ZeroPhaseButterworth(30.0, T_S, edge=Edge.REST),
        output_weight=tuple(weights),
        input_size=tuple(sizes),
        correction_weight=0.02,
        change_weight=0.05,
        tolerance=1e-9,
    )
    omega = 2.0 * np.pi * np.arange(2 * n_samples) / (2 * n_samples)
    G = weights[:, None] * response(T, omega) * sizes
    h = np.fft.ifft(G, axis=0).real  # (2 N, n, n)
    lag = np.subtract.outer(np.arange(n_samples), np.arange(n_samples)) % (2 * n_samples)
    A = h[lag].swapaxes(1, 2).reshape(n_samples * n, n_samples * n)
    F = by_column([low_pass(n_samples, 30.0, rest=True)] * n)
    scale = np.linalg.norm(G[0], 2) ** 2
    u, e = rng.standard_normal((2, n_samples, n))
    right = A.T @ F @ F @ (weights * e).ravel() - 0.02 * scale * (u / sizes).ravel()
    step = np.linalg.solve(A.T @ F @ F @ A + 0.07 * scale * np.eye(n * n_samples), right)
    assert close(law(u, e), u + sizes * step.reshape(n_samples, n))


@cases(6)
@given(
    order=st.integers(1, 14),
    n_samples=LENGTH,
    noise=st.sampled_from([0.01, 0.3]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_an_impulse_response_is_the_conditional_mean_of_its_prior(
    order, n_samples, noise, slowest, damping, seed
):
    """At the decay and the size found: E[g | y] and its covariance of the joint Gaussian."""
    rng = np.random.default_rng(seed)
    T = random_system(rng, order, slowest, damping)
    if not T.is_stable:
        return
    u = rng.standard_normal((n_samples, 1))
    y = T.simulate(u) + noise * rng.standard_normal((n_samples, 1))
    found = impulse_response(Sums.none(20).with_records(u, y))
    U = np.stack([shifted(n_samples, -i, hold=False) @ u[:, 0] for i in range(20)], axis=1)
    later = np.maximum.outer(np.arange(1, 21), np.arange(1, 21))
    least, best = np.inf, None
    for decay in DECAYS:
        for ratio in np.exp(np.linspace(-4.0, 18.0, 34)) / (np.square(U).sum() / 20):
            K = ratio * (decay**later + 1e-12 * np.eye(20))
            S = U @ K @ U.T + np.eye(n_samples)
            variance = float(y[:, 0] @ np.linalg.solve(S, y[:, 0])) / n_samples
            cost = n_samples * np.log(variance) + np.linalg.slogdet(S)[1]
            if cost < least - 1e-9:
                least, best = cost, (K, S, variance)
    assert best is not None
    K, S, variance = best
    gain = np.linalg.solve(S, U @ K).T
    assert close(found.taps, gain @ y[:, 0])
    assert close(found.covariance, variance * (K - gain @ U @ K))
