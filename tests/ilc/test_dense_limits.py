"""Asymptotic error, contraction of the error, rates and cutoffs beside dense references.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.ilc.analysis import asymptotic_error, heuristic_criterion
from armside.ilc.analysis.limits import largest_common_cutoff
from armside.ilc.analysis.record_iteration import RecordIteration
from armside.ilc.analysis.robustness import sampled_robustness
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrder, PType
from armside.ilc.laws.memory import HighOrder
from armside.ilc.laws.model_based import Gradient

from .dense_filters import MOTORS_AND_ORDER, by_column, low_pass, low_pass_gain, response, shifted
from .random_cases import AGREED, DAMPING, SEED, SLOWEST, T_S, cases, dense, random_matrix

L, Q = PType(gamma=0.4, delta=3), ZeroPhaseButterworth(20.0, T_S)


def drawn(seed, shape, *poles) -> Any:
    rng = np.random.default_rng(seed)
    return rng, random_matrix(rng, *shape, *poles)


def circulant(gains) -> Any:
    """(N n, N n) of responses (N, n, n) at all frequencies of a periodic record."""
    n_samples, n, _ = gains.shape
    h = np.fft.ifft(gains, axis=0).real
    lag = np.subtract.outer(np.arange(n_samples), np.arange(n_samples)) % n_samples
    return h[lag].swapaxes(1, 2).reshape(n_samples * n, n_samples * n)


@cases(6)
@given(
    shape=MOTORS_AND_ORDER,
    n_samples=st.sampled_from([50, 51, 120]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_the_asymptotic_error_is_the_fixed_point_of_the_periodic_iteration(
    shape, n_samples, slowest, damping, seed
):
    rng, T = drawn(seed, shape, slowest, damping)
    if not T.is_stable:
        return
    n, omega = shape[0], 2.0 * np.pi * np.arange(n_samples) / n_samples
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
    assert np.linalg.norm(found - expected) <= AGREED * np.linalg.norm(expected)


@cases(3)
@given(shape=MOTORS_AND_ORDER, slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_contractions_of_error_and_of_sampled_plants_are_singular_values(
    shape, slowest, damping, seed
):
    (_, T), n_samples = drawn(seed, shape, slowest, damping), 50
    if not T.is_stable:
        return
    n, G = shape[0], dense(T, n_samples)
    one, F = np.eye(len(G)), by_column([low_pass(n_samples, 20.0)] * n)
    M = by_column([0.4 * shifted(n_samples, 3)] * n)
    gradient = Gradient(T_u=T)
    found = RecordIteration(T, FirstOrder(L=gradient), n_samples, n).error_contraction
    assert found == pytest.approx(np.linalg.norm(one - gradient.step * G @ G.T, 2), rel=AGREED)
    sampled = sampled_robustness([T], FirstOrder(L=L, Q=Q), n_samples, n).contraction[0]
    assert sampled == pytest.approx(np.linalg.norm(F @ (one - M @ G), 2), rel=AGREED)


@cases(6)
@given(order=st.integers(1, 14), slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_the_rate_of_a_high_order_law_is_its_largest_root(order, slowest, damping, seed):
    """Roots of z^3 - Q sum (alpha_i - beta_i T L) z^(2 - i) at each frequency."""
    rng, T = drawn(seed, (1, order), slowest, damping)
    alpha, beta = rng.uniform(-0.5, 1.0, (2, 3))
    law = HighOrder(alpha=tuple(alpha), beta=tuple(beta), L=L, Q=Q)
    omega = rng.uniform(0.0, np.pi, 20)
    found = law.spectral_radius(T.response(omega), omega)
    gain, TL = low_pass_gain(omega, 20.0), response(T, omega)[:, 0, 0] * 0.4 * np.exp(3j * omega)
    for rho, q, tl in zip(found, gain, TL, strict=True):
        roots = np.roots(np.concatenate(([1.0], -q * (alpha - beta * tl))))
        assert rho == pytest.approx(np.abs(roots).max(), rel=AGREED)


@cases(2)
@given(shape=st.sampled_from([(2, 2), (3, 1)]), slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_the_largest_common_cutoff_is_the_edge_of_the_criterion(shape, slowest, damping, seed):
    _, T = drawn(seed, shape, slowest, damping)
    if not T.is_stable:
        return
    edge = largest_common_cutoff(T, 0.3, 3)
    if 1e-3 < edge < 120.0:
        below, above = (
            heuristic_criterion(T, 0.3, 3, ZeroPhaseButterworth(edge * factor, T_S))
            for factor in (1.0 - 1e-5, 1.0 + 1e-5)
        )
        assert below.is_met
        assert not above.is_met


def test_singular_values_close_together_are_found_or_said():
    """Of I - s G G^T nearly all are 1; more samples than the matrix is built for."""
    T = random_matrix(np.random.default_rng(441), 1, 3, 0.97, 1e-4)
    gradient, G = Gradient(T_u=T), dense(T, 350)
    expected = np.linalg.norm(np.eye(350) - gradient.step * G @ G.T, 2)
    try:
        found = RecordIteration(T, FirstOrder(L=gradient), 350, 1).error_contraction
    except RuntimeError as refused:
        assert "too many lie close to it" in str(refused)  # noqa: PT017
        return
    assert found == pytest.approx(expected, rel=AGREED)
