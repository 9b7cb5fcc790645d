"""Laws with parameters, points, laps or weights over frequency beside dense least squares.

A rational basis beside circulant matrices, minimax filters beside other searches on frequencies
that resolve every pole. One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI
tries ten times as many.
"""

import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline
from scipy.linalg import lu_factor, lu_solve
from scipy.optimize import minimize_scalar

from armside.ilc.filters import Edge, ZeroPhaseButterworth
from armside.ilc.identification.impulse_response import DECAYS, Sums, impulse_response
from armside.ilc.laws.first_order import PType
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse
from armside.ilc.laws.model_free import FiniteDifference, MeasuredGradient, b_splines
from armside.ilc.laws.norm_optimal import PointToPoint, RecordOptimal
from armside.ilc.laws.repetitive import Repetitive
from armside.ilc.laws.robust import h_infinity
from armside.ilc.laws.transfer import BasisFunctions, RationalBasis, across, derivatives
from armside.ilc.models.system import System

from .dense_filters import by_column, low_pass, low_pass_gain, response, shifted, tapered
from .random_cases import (
    AGREED,
    DAMPING,
    MOTORS_AND_ORDER,
    ONE_MOTOR,
    SEED,
    SHORT,
    SLOWEST,
    T_S,
    cases,
    close,
    dense,
    drawn,
    on_plants,
)  # fmt: skip

LENGTH = SHORT


def smooth(rng, n_samples, n):
    """A random walk twice summed, at rest at its start."""
    return low_pass(n_samples, 15.0) @ np.cumsum(rng.standard_normal((n_samples, n)), axis=0)


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
    # differences of outputs leave coefficients open whose effects nearly cancel, not their effect
    assert close(G @ (law(u, e) - u).ravel(), J @ c, size=float(np.linalg.norm(e)))


@on_plants(6, lengths=SHORT)
def test_a_point_to_point_step_is_the_least_squares_solution(case):
    rng, T, n, n_samples = case
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


@on_plants(6, st.sampled_from([(1, 1), (1, 14), (2, 4), (6, 1)]), SHORT)
def test_a_regularised_inverse_is_that_of_the_whole_transform(case):
    """One place, and two whose weights fade from one to the other."""
    rng, T, n, n_samples = case
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


@on_plants(
    4,
    st.sampled_from([(1, 1), (1, 4), (2, 2), (3, 1)]),
    st.sampled_from([50, 80]),
    damping=st.sampled_from([0.5, 0.05]),
)
def test_a_record_optimal_step_is_the_least_squares_solution(case):
    """Impulse responses wrap around at twice the record, which its poles leave at 1e-9."""
    rng, T, n, n_samples = case
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


@on_plants(6, ONE_MOTOR, SHORT, noise=st.sampled_from([0.01, 0.3]))
def test_an_impulse_response_is_the_conditional_mean_of_its_prior(noise, case):
    """At the decay and the size found: E[g | y] and its covariance of the joint Gaussian."""
    rng, T, _, n_samples = case
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


CIRCLES = st.sampled_from([50, 51] + ([120, 400] if os.environ.get("ARMSIDE_CI") else []))
"""Lengths whose matrices of a circle, four times as long, are inverted in each round."""


def around_a_circle(signal):
    """The record less its start, held as long again, and faded back over twice its length."""
    n = len(signal)
    fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, 2 * n + 1) / (2 * n + 1))
    moved = signal - signal[0]
    return np.vstack((moved, np.tile(moved[-1], (n, 1)), np.outer(fade, moved[-1])))


def rational_steps(G, r, wanted, p, m, rounds=15):
    """u of each round by circulant matrices and lstsq, and the wanted output it leaves."""
    n, n_columns = r.shape
    whole = 4 * n
    psi = (np.eye(whole) - np.roll(np.eye(whole), 1, axis=0)) / T_S

    def through_G(x):
        return (G @ x.T.reshape(n_columns, n, 1))[:, :, 0].T

    moved = through_G(r - r[0])
    powers = [np.linalg.matrix_power(psi, i) for i in range(1, max(p, m) + 1)]
    b = np.zeros(m)
    for _ in range(rounds):
        B = np.eye(whole) + sum(c * D for c, D in zip(b, powers, strict=False))
        factor = lu_factor(B)

        def term(signal, D, factor=factor):
            return lu_solve(factor, D @ around_a_circle(signal))[:n].ravel()

        columns = [term(moved, D) for D in powers[:p]] + [-term(wanted, D) for D in powers[:m]]
        A = np.stack(columns, axis=1)
        size = np.linalg.norm(A, axis=0)
        c = np.linalg.lstsq(A / size, term(wanted, np.eye(whole)), rcond=1e-13)[0] / size
        a, b = c[:p], c[p:]
        N = sum(c * D for c, D in zip(a, powers, strict=False))
        B = np.eye(whole) + sum(c * D for c, D in zip(b, powers, strict=False))
        u = np.linalg.solve(B, N @ around_a_circle(r))[:n]
        yield u, np.linalg.norm(wanted - through_G(u))


@on_plants(
    4,
    ONE_MOTOR,
    CIRCLES,
    n=st.integers(1, 6),
    terms=st.sampled_from([(1, 0), (3, 0), (1, 1), (2, 1), (4, 2)]),
    smooth=st.booleans(),
)
def test_a_step_in_a_rational_basis_is_that_of_its_matrices(n, terms, smooth, case):
    """Least squares weighted with the last denominator; the round that leaves least is kept.

    Rounding grows from round to round, in the reference too: by how much shows where r moves by
    1e-13, and a hundred times that is granted.
    """
    rng, T, _, n_samples = case
    F = low_pass(n_samples, 15.0)
    r = F @ np.cumsum(rng.standard_normal((n_samples, n)), axis=0)
    u, e = (F @ x if smooth else x for x in rng.standard_normal((2, n_samples, n)))
    law = RationalBasis(T_u=T, reference=r, n_numerator=terms[0], n_denominator=terms[1])
    G = dense(T, n_samples)
    moved = r * (1.0 + 1e-13 * rng.standard_normal(r.shape))
    expected, other = (
        min(rational_steps(G, path, e + G @ u, *terms), key=lambda step: step[1])[0]
        for path in (r, moved)
    )
    rounding = 100.0 * np.linalg.norm(other - expected)
    assert close(law(u, e), expected, rounding / AGREED)


GRID = np.pi * (np.arange(600) + 0.5) / 600
"""On which the filter is found, and to which it adds peaks."""


def resolving(T):
    """Frequencies between which neither T nor a filter of 24 taps has a peak of its own."""
    near = [(max(1.0 - abs(p), 1e-6), np.angle(p)) for p in T.poles]
    around = [angle + width * np.tan(np.linspace(-1.57, 1.57, 61)) for width, angle in near]
    return np.unique(np.clip(np.concatenate([GRID, [0.0, np.pi], *around]), 0.0, np.pi))


def dense_rows(T, cutoff, delays, uncertainty, omega):
    """Real rows of Q (1 - L T) and of Delta Q L T, right side less rows times taps."""
    q = low_pass_gain(omega, cutoff)
    A = (q * response(T, omega)[:, 0, 0])[:, None] * np.exp(1j * np.outer(omega, delays))
    parts = A.real, A.imag, uncertainty * A.real, uncertainty * A.imag
    return np.concatenate(parts), np.append(q, np.zeros(3 * len(q)))


def value(A, b, taps):
    """(M,) of the criterion."""
    return np.sqrt(np.square((A @ taps - b).reshape(4, -1)).sum(axis=0))


def largest(T, cutoff, delays, uncertainty, taps, omega):
    """Supremum of the criterion: the largest on a grid, and what is between its neighbours."""

    def size(omega):
        return value(*dense_rows(T, cutoff, delays, uncertainty, np.atleast_1d(omega)), taps)

    sizes, found = size(omega), [0.0]
    for i in np.argsort(sizes)[-5:]:
        ends = float(omega[max(i - 1, 0)]), float(omega[min(i + 1, len(omega) - 1)])
        best = minimize_scalar(
            lambda w: -float(size(w)[0]), bounds=ends, method="bounded", options={"xatol": 1e-13}
        )
        found.append(-float(best.fun))
    return max(float(sizes.max()), *found)


def others(rng, A, b, taps):
    """Neighbours of the taps, and searches by reweighted least squares with ridges of all sizes."""
    size = np.linalg.norm(taps)
    for scale in (1e-6, 1e-4, 1e-2, 1e-1):
        for change in rng.standard_normal((20, len(taps))):
            yield taps + scale * size / np.linalg.norm(change) * change
    for ridge in (1e-14, 1e-10, 1e-6, 1e-3):
        weight = np.full(len(A) // 4, 4.0 / len(A))
        for _ in range(20):
            root = np.sqrt(np.tile(weight, 4))
            rows = root[:, None] * A
            small = np.sqrt(ridge) * np.linalg.norm(rows, 2) * np.eye(len(taps))
            right = np.append(root * b, np.zeros(len(taps)))
            found = np.linalg.lstsq(np.vstack((rows, small)), right, rcond=None)[0]
            yield found
            weight = weight * value(A, b, found)
            weight = weight / weight.sum()


@on_plants(
    4,
    ONE_MOTOR,
    SHORT,
    n_taps=st.sampled_from([1, 5, 12, 24]),
    cutoff=st.floats(2.0, 60.0),
    uncertainty=st.sampled_from([0.0, 0.3]),
)
def test_no_other_search_beats_the_stated_bound_of_a_minimax_filter(
    n_taps, cutoff, uncertainty, case
):
    rng, T, *_ = case
    lead, Q = int(rng.integers(0, n_taps)), ZeroPhaseButterworth(cutoff, T_S)
    L = h_infinity(T, Q, n_taps=n_taps, lead=lead, uncertainty=uncertainty)
    omega, about = resolving(T), (T, cutoff, lead - np.arange(n_taps), uncertainty)
    reached = largest(*about, L.taps, omega)
    assert L.reached == pytest.approx(reached, rel=AGREED)
    assert reached * (1.0 - AGREED) <= L.bound <= L.reached * (1.0 + AGREED)
    A, b = dense_rows(*about, omega)
    for taps in others(rng, A, b, L.taps):
        if np.linalg.norm(taps) <= L.bounded and value(A, b, taps).max() < L.least:
            assert largest(*about, taps, omega) >= (1.0 - AGREED) * L.least


SERVO = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1.0, -0.4884]), T_S)


def resonant(omega, damping):
    """The servo beside a resonance of gain 2, at omega [rad/sample]."""
    pole = np.exp(omega * (-damping + 1j))
    a = np.poly([pole, pole.conjugate()]).real
    ring = np.convolve([0, 4.0 * damping * omega * np.sin(omega)], SERVO.a)
    b = np.convolve(SERVO.b, a) + np.pad(ring, (0, 5))
    return System(b, np.convolve(SERVO.a, a), T_S)


def test_a_resonance_between_the_frequencies_of_the_grid_is_found():
    """Half way between two of them, a hundredth as wide as the grid is fine."""
    omega, cutoff, n_taps = np.pi * 101 / 600, 60.0, 40
    T, Q = resonant(omega, 1e-4), ZeroPhaseButterworth(60.0, T_S)
    L = h_infinity(T, Q, n_taps=n_taps)
    about = T, cutoff, n_taps // 2 - np.arange(n_taps), 0.0
    assert L.reached == pytest.approx(largest(*about, L.taps, resolving(T)), rel=AGREED)
    rigid = h_infinity(SERVO, Q, n_taps=n_taps)
    on_grid = value(*dense_rows(*about, GRID), rigid.taps).max()
    assert largest(*about, rigid.taps, resolving(T)) > 1.1 * on_grid
