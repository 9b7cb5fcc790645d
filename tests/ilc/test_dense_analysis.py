"""Analysis and design beside dense searches, eigenvalues and singular values, on random cases.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

from armside.ilc.analysis import (
    LiftedIteration,
    asymptotic_error,
    heuristic_criterion,
    largest_cutoff,
    largest_gamma,
)
from armside.ilc.analysis.proposal import propose
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.laws.first_order import PType
from armside.ilc.laws.heuristic import Heuristic

from .dense_filters import by_column, low_pass_gain, response
from .random_cases import (
    AGREED,
    ONE_MOTOR,
    ORDER,
    SHORT,
    T_S,
    close,
    dense,
    entries_of,
    on_plants,
)


def not_none(bound) -> float:
    assert bound is not None
    return bound


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


@on_plants(
    10,
    st.tuples(st.sampled_from([1, 1, 1, 2, 3]), ORDER),
    SHORT,
    gamma=st.floats(0.01, 2.0),
    delta=st.integers(-3, 12),
    cutoff=st.floats(1.0, 100.0),
)
def test_the_criterion_is_the_supremum_over_frequencies(gamma, delta, cutoff, case):
    """Singular values on a grid that resolves every resonance; nothing is above the bound."""
    _, T, n, _ = case
    filters: Any = (ZeroPhaseButterworth(cutoff, T_S), ALL_PASS)
    for Q in filters:
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


@on_plants(20, ONE_MOTOR, SHORT, delta=st.integers(0, 8))
def test_the_largest_gain_is_the_edge_of_the_criterion(delta, case):
    """Just below it the supremum over frequencies is below 1, just above it is not."""
    rng, T, *_ = case
    cutoff = 10.0 ** rng.uniform(0.0, 1.8)
    gamma = largest_gamma(T, [delta], [cutoff])[0, 0]
    Q = ZeroPhaseButterworth(cutoff, T_S)
    omega = narrow_grid(T, Q.poles)[1:]
    LT = np.exp(1j * delta * omega) * T.response(omega)

    def contraction(gain):
        return (Q.response(omega) * np.abs(1.0 - gain * LT)).max()

    if gamma > 1e-9:
        assert contraction(gamma * (1 - 1e-5)) <= 1.0 + 1e-9
    assert not_none(heuristic_criterion(T, (gamma + 1e-12) * (1 + 1e-5), delta, Q).bound) >= 1.0
    edge = largest_cutoff(T, 0.5 * gamma, delta) if gamma > 1e-9 else np.inf
    if np.isfinite(edge) and edge < 120.0:
        assert edge >= cutoff * (1 - 1e-6)  # half the largest gain of this cutoff admits it
        above = ZeroPhaseButterworth(min(edge * (1 + 1e-4), 124.9), T_S)
        assert not_none(heuristic_criterion(T, 0.5 * gamma, delta, above).bound) >= 1.0 - 1e-9


@on_plants(10, ONE_MOTOR, SHORT, power=st.sampled_from([1, 3, 40]))
def test_growth_and_fixed_point_are_those_of_the_dense_iteration(power, case):
    rng, T, _, n_samples = case
    Q = ZeroPhaseButterworth(20.0, T_S)
    law = Heuristic(Q=Q, gamma=0.3, delta=2)
    lifted = LiftedIteration.build(T, law, n_samples)
    sos = butter(2, 20.0, fs=1.0 / T_S, output="sos")
    identity = np.eye(n_samples)
    low = sosfiltfilt(sos, identity, axis=0, padtype="odd", padlen=6)
    ahead = np.minimum(np.arange(n_samples) + 2, n_samples - 1)
    dense_iteration = low @ (identity - 0.3 * identity[ahead] @ dense(T, n_samples))
    scale = float(np.linalg.norm(dense_iteration, 2))
    np.testing.assert_allclose(lifted.iteration, dense_iteration, rtol=0, atol=1e-9 * scale)
    expected = np.linalg.norm(np.linalg.matrix_power(dense_iteration, power), 2)
    assert lifted.transient_growth([0, power]) == pytest.approx([1.0, expected], rel=AGREED)
    e_0 = rng.standard_normal((n_samples, 1))
    u, limit = lifted.fixed_point(e_0)
    left = u - dense_iteration @ u - 0.3 * low @ e_0[ahead]
    assert np.abs(left).max() <= AGREED * max(np.abs(u).max(), 1.0)
    e_inf = e_0 - dense(T, n_samples) @ u
    np.testing.assert_allclose(limit, e_inf, atol=AGREED * np.abs(u).max() * scale)


L, Q = PType(gamma=0.4, delta=3), ZeroPhaseButterworth(20.0, T_S)


def circulant(gains) -> Any:
    """(N n, N n) of responses (N, n, n) at all frequencies of a periodic record."""
    n_samples, n, _ = gains.shape
    h = np.fft.ifft(gains, axis=0).real
    lag = np.subtract.outer(np.arange(n_samples), np.arange(n_samples)) % n_samples
    return h[lag].swapaxes(1, 2).reshape(n_samples * n, n_samples * n)


@on_plants(6, lengths=SHORT)
def test_the_asymptotic_error_is_the_fixed_point_of_the_periodic_iteration(case):
    rng, T, n, n_samples = case
    omega = 2.0 * np.pi * np.arange(n_samples) / n_samples
    one = np.eye(n)
    low = low_pass_gain(np.minimum(omega, 2.0 * np.pi - omega), 20.0)[:, None, None] * one
    ahead = 0.4 * np.roll(np.eye(n_samples), 3, axis=1)
    G, F, M = circulant(response(T, omega)), circulant(low), by_column([ahead] * n)
    e_0 = rng.standard_normal((n_samples, n))
    left = np.eye(len(G)) - F @ (np.eye(len(G)) - M @ G)
    if np.linalg.norm(left, ord=-2) < 1e-12:  # without a limit
        with pytest.raises(ValueError, match="no asymptotic error"):
            asymptotic_error(e_0, T, L, Q)
        return
    expected = e_0.ravel() - G @ np.linalg.solve(left, F @ M @ e_0.ravel())
    found = asymptotic_error(e_0, T, L, Q).ravel()
    assert close(found, expected)


@on_plants(3, ONE_MOTOR, SHORT, bandwidth=st.floats(2.0, 60.0))
def test_a_proposal_is_the_best_of_its_shifts(bandwidth, case):
    """Every shift with its gain and contraction; among nearly equal ones the widest."""
    T = case.T * float(np.sign(case.T.static_gain))
    Q, found = ZeroPhaseButterworth(bandwidth, T_S), None
    limits = largest_gamma(T, range(4), [bandwidth])[:, 0]
    gammas = np.minimum(1.0 / T.static_gain, 0.6 * limits)
    each = [heuristic_criterion(T, g, d, Q).contraction for d, g in enumerate(gammas)]
    try:
        found = propose(T, bandwidth, deltas=range(4))
    except ValueError as refused:
        assert "infeasible design" in str(refused)  # noqa: PT017
        assert min(each) > 0.99
        return
    assert (found.gamma, found.largest_gamma) == (gammas[found.delta], limits[found.delta])
    assert found.contraction == pytest.approx(each[found.delta])
    # The least over frequency of the larger root in gamma of |1 - gamma z|^2 q^2 = 1.
    omega = narrow_grid(T, Q.poles)[1:]
    z, q = (
        np.exp(1j * found.delta * omega) * response(T, omega)[:, 0, 0],
        low_pass_gain(omega, bandwidth),
    )
    square = np.abs(z) ** 2
    excess = np.maximum(1.0 / np.maximum(q, 1e-150) ** 2 - 1.0, 0.0)
    root = (z.real + np.sqrt(z.real**2 + square * excess)) / np.maximum(square, 1e-300)
    assert found.largest_gamma == pytest.approx(root.min(), rel=1e-4)
    assert found.contraction == pytest.approx((q * np.abs(1.0 - found.gamma * z)).max(), rel=1e-4)
    near = [limit for limit, size in zip(limits, each, strict=True) if size <= min(each) + 0.005]
    assert found.largest_gamma == max(near)
