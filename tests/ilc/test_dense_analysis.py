"""Analysis and design beside dense searches, eigenvalues and singular values, on random cases.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import minimize_scalar
from scipy.signal import bilinear, butter, freqz, sosfiltfilt

from armside.ilc.analysis import (
    LiftedIteration,
    asymptotic_error,
    heuristic_criterion,
    largest_cutoff,
    largest_gamma,
)
from armside.ilc.analysis.proposal import propose
from armside.ilc.analysis.robustness import PARAMETERS, contraction_map, monte_carlo
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.laws.first_order import PType
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.models.two_mass import TwoMassJoint, TwoMassLoop

from .dense_filters import by_column, low_pass_gain, response
from .random_cases import (
    AGREED,
    ONE_MOTOR,
    ORDER,
    SEED,
    SHORT,
    T_S,
    cases,
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


def fine(poles):
    """Frequencies that resolve every pole, (M,)."""
    grid = [np.linspace(0.0, np.pi, 6001), np.geomspace(1e-6, np.pi, 2001)]
    for pole in np.unique(poles):
        width = max(1.0 - abs(pole), 1e-9)
        grid.append(abs(np.angle(pole)) + width * np.tan(np.linspace(-1.57, 1.57, 801)))
    return np.unique(np.clip(np.concatenate(grid), 0.0, np.pi))


def largest(size, omega) -> float:
    """max of size(omega): the highest points of the grid, each refined between its neighbours."""
    value = size(omega)
    found = [float(value.max())]
    for i in np.argsort(value)[-3:]:
        ends = float(omega[max(i - 1, 0)]), float(omega[min(i + 1, len(omega) - 1)])
        best: Any = minimize_scalar(
            lambda w: -float(size(np.atleast_1d(w))[0]),
            bounds=ends,
            method="bounded",
            options={"xatol": 1e-12, "maxiter": 60},
        )
        found.append(-float(best.fun))
    return max(found)


def heuristic_size(T, gamma, delta, q):
    """|Q| |1 - gamma q^delta T| at omega."""
    return lambda w: q(w) * np.abs(1.0 - gamma * np.exp(1j * delta * w) * T(w))


def dense_contraction(T, delta, gamma, cutoff):
    size = heuristic_size(
        lambda w: response(T, w)[:, 0, 0], gamma, delta, lambda w: low_pass_gain(w, cutoff)
    )
    return largest(size, fine(T.poles))


def searched_gamma(T, delta, cutoff):
    """Least over frequency of the larger root in gamma of |1 - gamma z|^2 Q^2 = 1."""

    def reciprocal(w):
        z, q = np.exp(1j * delta * w) * response(T, w)[:, 0, 0], low_pass_gain(w, cutoff)
        with np.errstate(divide="ignore"):
            excess = 1.0 / np.maximum(q, 1e-150) ** 2 - 1.0
        root = z.real + np.sqrt(z.real**2 + np.abs(z) ** 2 * np.maximum(excess, 0.0))
        return np.abs(z) ** 2 / np.maximum(root, 1e-300)

    return 1.0 / largest(reciprocal, fine(T.poles)[1:])


@on_plants(3, ONE_MOTOR, SHORT, bandwidth=st.floats(2.0, 60.0))
def test_a_proposal_is_the_best_of_a_dense_search(bandwidth, case):
    """Every shift with its largest gain and contraction; among nearly equal ones the widest."""
    T = case.T * float(np.sign(case.T.static_gain))
    at_rest = abs(float(T.b.sum() / T.a.sum()))
    candidates = {}
    for delta in range(4):
        limit = searched_gamma(T, delta, bandwidth)
        gamma = min(1.0 / at_rest, 0.6 * limit)
        candidates[delta] = gamma, limit, dense_contraction(T, delta, gamma, bandwidth)
    fastest = min(each[2] for each in candidates.values())
    try:
        found = propose(T, bandwidth, deltas=range(4))
    except ValueError as refused:
        assert "infeasible design" in str(refused)  # noqa: PT017
        assert fastest > 0.99 * (1.0 - AGREED)
        return
    gamma, limit, reached = candidates[found.delta]
    assert (found.gamma, found.largest_gamma) == pytest.approx((gamma, limit), rel=AGREED)
    assert found.contraction == pytest.approx(reached, rel=AGREED)
    near = [each[1] for each in candidates.values() if each[2] <= fastest + 0.005 - AGREED]
    assert reached <= fastest + 0.005 + AGREED
    assert limit >= max(near) * (1.0 - AGREED)


def two_mass(loop):
    """Response of T_{u,m} and its poles: matrix exponential, Tustin, states of the closed loop."""
    joint, pd, T = loop.joint, loop.controller, loop.sample_time
    A, B = joint.state_space
    whole: Any = expm(T * np.block([[A, B], [np.zeros((1, 5))]]))
    A, B, C = whole[:4, :4], whole[:4, 4:], np.array([[0.0, 0.0, 1.0, 0.0]])
    # F = D + k / (q - p) with Tustin's s
    b, a = bilinear([pd.Kd + pd.Kp * pd.Tf, pd.Kp], [pd.Tf, 1.0], 1.0 / T)
    p, D = -a[1] / a[0], b[0] / a[0]
    k = b[1] / a[0] + p * D
    closed = np.block([[A - D * B @ C, k * B], [-C, np.array([[p]])]])

    def T_u(omega):
        z = np.exp(1j * np.asarray(omega))
        states = np.linalg.solve(z[:, None, None] * np.eye(4) - A, np.tile(B, (len(z), 1, 1)))
        GF = (C @ states)[:, 0, 0] * (D + k / (z - p))
        return GF / (1.0 + GF)

    return T_u, np.linalg.eigvals(closed)


def two_mass_contraction(loop, gamma, delta, cutoff):
    T_u, poles = two_mass(loop)
    if np.abs(poles).max() >= 1.0:
        return np.inf
    q = butter_gain(cutoff, loop.sample_time)
    return largest(heuristic_size(T_u, gamma, delta, q), fine(poles)[1:])


def butter_gain(cutoff, sample_time):
    b, a = butter(2, cutoff, fs=1.0 / sample_time)
    return lambda omega: np.abs(freqz(b, a, omega)[1]) ** 2


@cases(3)
@given(
    spread=st.sampled_from([0.2, 1.0, 4.0]),
    damping=st.sampled_from([0.0, 0.01, 1.0]),
    delta=st.integers(0, 8),
    cutoff=st.floats(2.0, 40.0),
    seed=SEED,
)
def test_robustness_of_a_two_mass_joint_is_that_of_dense_grids(
    spread, damping, delta, cutoff, seed
):
    """Each sampled joint, and a map over two of its parameters; unstable loops are infinite."""
    rng = np.random.default_rng(seed)
    loop = TwoMassLoop(joint=TwoMassJoint(d=0.25 * damping))
    gamma = float(rng.uniform(0.2, 1.2))
    law = Heuristic(Q=ZeroPhaseButterworth(cutoff, loop.sample_time), gamma=gamma, delta=delta)

    def dense_of(factors):
        scaled = {name: f * getattr(loop.joint, name) for name, f in factors.items()}
        other = replace(loop, joint=replace(loop.joint, **scaled))
        return two_mass_contraction(other, gamma, delta, cutoff)

    found = monte_carlo(loop, law, spread, 3, rng)
    for row, value in zip(found.factors, found.contraction, strict=True):
        expected = dense_of(dict(zip(PARAMETERS, row, strict=True)))
        assert value == pytest.approx(expected, rel=AGREED)
    first, second = rng.choice(PARAMETERS, 2, replace=False).tolist()
    factors = np.exp(rng.uniform(-1.0, 1.0, (2, 2))).tolist()
    over = contraction_map(loop, law, (first, factors[0]), (second, factors[1]))
    each = [[dense_of({first: x, second: y}) for y in factors[1]] for x in factors[0]]
    np.testing.assert_allclose(over, each, rtol=AGREED)
