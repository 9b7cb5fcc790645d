"""First-order laws beside their dense matrices on random cases: one update, u_1 = Q (u + L e).

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.ilc.filters import End, ZeroPhaseButterworth
from armside.ilc.laws import Heuristic
from armside.ilc.laws.first_order import Blend, DType, FirstOrder, MatrixGain, PType
from armside.ilc.laws.model_based import Beyond, Gradient, ModelInverse
from armside.ilc.laws.robust import Matched
from armside.ilc.laws.wrappers import JointSpace

from .dense_filters import (
    LENGTH,
    LONGEST,
    MOTORS_AND_ORDER,
    by_column,
    largest_gain,
    low_pass,
    low_pass_gain,
    response,
    shifted,
)
from .random_cases import AGREED, DAMPING, SEED, SLOWEST, T_S, cases, dense, random_matrix


def p_type(rng, T, n, n_samples) -> Any:
    gamma, delta, hold = rng.uniform(0.1, 1.0), int(rng.integers(-5, 20)), rng.random() < 0.5
    L = PType(gamma=gamma, delta=delta, end=End.HOLD if hold else End.ZERO)
    return L, by_column([gamma * shifted(n_samples, delta, hold)] * n)


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
@cases(3)
@given(shape=MOTORS_AND_ORDER, n_samples=LENGTH, slowest=SLOWEST, damping=DAMPING, seed=SEED)
def test_an_update_is_that_of_its_matrices(build, shape, n_samples, slowest, damping, seed):
    rng, (n, order) = np.random.default_rng(seed), shape
    n_samples = min(n_samples, LONGEST // n)
    T = random_matrix(rng, n, order, slowest, damping)
    if not T.is_stable:
        return
    cutoffs = rng.uniform(1.0, 100.0, n)
    Q = by_column([low_pass(n_samples, f) for f in cutoffs])
    L, matrix = build(rng, T, n, n_samples)
    law = FirstOrder(L=L, Q=ZeroPhaseButterworth(tuple(cutoffs.tolist()), T_S))
    u, e = rng.standard_normal((2, n_samples, n))
    expected = Q @ (u.ravel() + matrix @ e.ravel())
    assert np.linalg.norm(law(u, e).ravel() - expected) <= AGREED * np.linalg.norm(expected)


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
        assert np.linalg.norm(found[:, j] - expected) <= AGREED * np.linalg.norm(expected)


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
    rng, (n, order) = np.random.default_rng(seed), shape
    n_samples = min(n_samples, LONGEST // n)
    T = random_matrix(rng, n, order, slowest, damping)
    if not T.is_stable:
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
    assert np.linalg.norm(L(e) - expected) <= AGREED * np.linalg.norm(expected)
