"""Analysis beside a dense or scipy reference on random cases: agree or refuse.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4. A refusal is an error that says
so; a result that differs is a failure. CI tries ten times as many cases.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

from armside.ilc.analysis import LiftedIteration, heuristic_criterion, largest_cutoff, largest_gamma
from armside.ilc.analysis.limits import largest_gain_factor
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.laws import Heuristic

from .random_cases import (
    AGREED,
    DAMPING,
    ORDER,
    SEED,
    SLOWEST,
    T_S,
    cases,
    dense,
    entries_of,
    random_matrix,
    random_system,
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
    assert not_none(heuristic_criterion(T, (gamma + 1e-12) * (1 + 1e-5), delta, Q).bound) >= 1.0
    edge = largest_cutoff(T, 0.5 * gamma, delta) if gamma > 1e-9 else np.inf
    if np.isfinite(edge) and edge < 120.0:
        assert edge >= cutoff * (1 - 1e-6)  # half the largest gain of this cutoff admits it
        above = ZeroPhaseButterworth(min(edge * (1 + 1e-4), 124.9), T_S)
        assert not_none(heuristic_criterion(T, 0.5 * gamma, delta, above).bound) >= 1.0 - 1e-9


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
    scale = float(np.linalg.norm(dense_iteration, 2))
    np.testing.assert_allclose(lifted.iteration, dense_iteration, rtol=0, atol=1e-9 * scale)
    expected = np.linalg.norm(np.linalg.matrix_power(dense_iteration, power), 2)
    assert lifted.transient_growth(power)[0] == pytest.approx(expected, rel=AGREED)
    e_0 = rng.standard_normal((n_samples, 1))
    u, limit = lifted.fixed_point(e_0)
    left = u - dense_iteration @ u - 0.3 * low @ e_0[ahead]
    assert np.abs(left).max() <= AGREED * max(np.abs(u).max(), 1.0)
    e_inf = e_0 - dense(T, n_samples) @ u
    np.testing.assert_allclose(limit, e_inf, atol=AGREED * np.abs(u).max() * scale)
