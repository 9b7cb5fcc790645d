"""Minimax filters beside other searches on the same grid of frequencies, by dense rows.

One motor, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.h_infinity import h_infinity

from .dense_filters import low_pass_gain, response
from .random_cases import AGREED, DAMPING, ORDER, SEED, SLOWEST, T_S, cases, random_system

OMEGA = np.pi * (np.arange(600) + 0.5) / 600


def dense_rows(T, cutoff, delays, uncertainty):
    """Real rows of Q (1 - L T) and of Delta Q L T, right side less rows times taps."""
    q = low_pass_gain(OMEGA, cutoff)
    A = (q * response(T, OMEGA)[:, 0, 0])[:, None] * np.exp(1j * np.outer(OMEGA, delays))
    parts = A.real, A.imag, uncertainty * A.real, uncertainty * A.imag
    return np.concatenate(parts), np.append(q, np.zeros(3 * len(q)))


def value(A, b, taps):
    """(600,) of the criterion."""
    return np.sqrt(np.square((A @ taps - b).reshape(4, -1)).sum(axis=0))


def others(rng, A, b, taps):
    """Neighbours of the taps, and searches by reweighted least squares with ridges of all sizes."""
    size = np.linalg.norm(taps)
    for scale in (1e-6, 1e-4, 1e-2, 1e-1):
        for change in rng.standard_normal((20, len(taps))):
            yield taps + scale * size / np.linalg.norm(change) * change
    for ridge in (1e-14, 1e-10, 1e-6, 1e-3):
        weight = np.full(len(OMEGA), 1.0 / len(OMEGA))
        for _ in range(20):
            root = np.sqrt(np.tile(weight, 4))
            rows = root[:, None] * A
            small = np.sqrt(ridge) * np.linalg.norm(rows, 2) * np.eye(len(taps))
            right = np.append(root * b, np.zeros(len(taps)))
            found = np.linalg.lstsq(np.vstack((rows, small)), right, rcond=None)[0]
            yield found
            weight = weight * value(A, b, found)
            weight = weight / weight.sum()


@cases(4)
@given(
    order=ORDER,
    n_taps=st.sampled_from([1, 5, 12, 24]),
    cutoff=st.floats(2.0, 60.0),
    uncertainty=st.sampled_from([0.0, 0.3]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_no_other_search_beats_the_stated_bound_of_a_minimax_filter(
    order, n_taps, cutoff, uncertainty, slowest, damping, seed
):
    rng = np.random.default_rng(seed)
    T = random_system(rng, order, slowest, damping)
    if not T.is_stable:
        return
    lead, Q = int(rng.integers(0, n_taps)), ZeroPhaseButterworth(cutoff, T_S)
    L = h_infinity(T, Q, n_taps=n_taps, lead=lead, uncertainty=uncertainty)
    A, b = dense_rows(T, cutoff, lead - np.arange(n_taps), uncertainty)
    assert value(A, b, L.taps).max() == pytest.approx(L.reached, rel=AGREED)
    for taps in others(rng, A, b, L.taps):
        if np.linalg.norm(taps) <= L.bounded:
            assert value(A, b, taps).max() >= (1.0 - AGREED) * L.least
