"""Minimax filters beside other searches, by dense rows on frequencies that resolve every pole.

One motor, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.robust import h_infinity
from armside.ilc.models.system import System

from .dense_filters import low_pass_gain, response
from .random_cases import AGREED, DAMPING, ORDER, SEED, SLOWEST, T_S, cases, random_system

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
