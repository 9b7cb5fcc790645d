"""A step in a rational basis beside circulant matrices and least squares, on random plants.

One to six motors with one plant of order 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten
times as many.
"""

import os

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import lu_factor, lu_solve

from armside.ilc.laws.transfer import RationalBasis

from .dense_filters import low_pass
from .random_cases import AGREED, DAMPING, ORDER, SEED, SLOWEST, T_S, cases, dense, random_system

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


@cases(4)
@given(
    order=ORDER,
    n=st.integers(1, 6),
    n_samples=CIRCLES,
    terms=st.sampled_from([(1, 0), (3, 0), (1, 1), (2, 1), (4, 2)]),
    slowest=SLOWEST,
    damping=DAMPING,
    smooth=st.booleans(),
    seed=SEED,
)
def test_a_step_in_a_rational_basis_is_that_of_its_matrices(
    order, n, n_samples, terms, slowest, damping, smooth, seed
):
    """Least squares weighted with the last denominator; the round that leaves least is kept."""
    rng = np.random.default_rng(seed)
    T = random_system(rng, order, slowest, damping)
    if not T.is_stable:
        return
    F = low_pass(n_samples, 15.0)
    r = F @ np.cumsum(rng.standard_normal((n_samples, n)), axis=0)
    u, e = (F @ x if smooth else x for x in rng.standard_normal((2, n_samples, n)))
    law = RationalBasis(T_u=T, reference=r, n_numerator=terms[0], n_denominator=terms[1])
    G = dense(T, n_samples)
    expected, _ = min(rational_steps(G, r, e + G @ u, *terms), key=lambda step: step[1])
    assert np.linalg.norm(law(u, e) - expected) <= AGREED * np.linalg.norm(expected)
