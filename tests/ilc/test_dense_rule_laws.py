"""Learning on a simulation and by segment beside dense matrices, on random plants.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrder, PType
from armside.ilc.laws.wrappers import BySegment, Simulated

from .dense_filters import LENGTH, LONGEST, MOTORS_AND_ORDER, by_column, low_pass, shifted
from .random_cases import (
    AGREED,
    DAMPING,
    SEED,
    SLOWEST,
    T_S,
    cases,
    dense,
    random_matrix,
)

GAMMA, DELTA, CUTOFF = 0.4, 3, 20.0
LAW = FirstOrder(L=PType(gamma=GAMMA, delta=DELTA), Q=ZeroPhaseButterworth(CUTOFF, T_S))


def close(found, expected, size=0.0):
    return np.linalg.norm(found - expected) <= AGREED * max(np.linalg.norm(expected), size)


def matrices(n_samples, n) -> Any:
    """Dense L and Q of LAW."""
    L = by_column([GAMMA * shifted(n_samples, DELTA)] * n)
    return L, by_column([low_pass(n_samples, CUTOFF)] * n)


def passes(G, e_0, u, unexplained, number):
    """Corrections and residuals of the passes on the simulated plant."""
    L, Q = matrices(*e_0.shape)
    us = [u.ravel()]
    for _ in range(number):
        us.append(Q @ (us[-1] + L @ (e_0.ravel() - G @ us[-1] + unexplained)))
    return us, [(e_0.ravel() - G @ each + unexplained).reshape(u.shape) for each in us]


def last_pass(sizes):
    """The third running that is not 2 % smaller than the least before it, or the last of all."""
    fruitless = [k > 0 and sizes[k] >= 0.98 * min(sizes[:k]) for k in range(len(sizes))]
    ends = [k for k in range(2, len(sizes)) if all(fruitless[k - 2 : k + 1])]
    return ends[0] if ends else len(sizes) - 1


@cases(5)
@given(
    shape=MOTORS_AND_ORDER,
    n_samples=LENGTH,
    number=st.sampled_from([1, 4, 12, 30]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_learning_on_a_simulation_is_that_of_its_matrices(
    shape, n_samples, number, slowest, damping, seed
):
    """Passes u + L r, r with what the simulation leaves unexplained; the least residual is kept."""
    rng, (n, order) = np.random.default_rng(seed), shape
    n_samples = min(n_samples, LONGEST // n)
    T = random_matrix(rng, n, order, slowest, damping)
    if not T.is_stable:
        return
    e_0, u, e = rng.standard_normal((3, n_samples, n))
    weight, G = rng.uniform(0.5, 2.0, n), dense(T, n_samples)
    law = Simulated(
        simulation=lambda v: e_0 - T.simulate(v),
        law=LAW,
        Q_d=ZeroPhaseButterworth(40.0, T_S),
        weight=tuple(weight.tolist()),
        passes=number,
    )
    filtered = by_column([low_pass(n_samples, 40.0)] * n)
    unexplained = filtered @ (e.ravel() - e_0.ravel() + G @ u.ravel())
    us, residuals = passes(G, e_0, u, unexplained, number)
    sizes = [np.abs(r * weight).max() for r in residuals]
    kept = int(np.argmin(sizes[: last_pass(sizes) + 1]))
    assert close(law(u, e).ravel(), us[kept])


def last_of(sizes, least, patience):
    """Run after which a segment keeps its best correction, or None."""
    stalls = [k > 0 and sizes[k] > (1.0 - least) * min(sizes[:k]) for k in range(len(sizes))]
    ends = (k for k in range(1, len(sizes)) if all(stalls[max(k - patience + 1, 0) : k + 1]))
    return next(ends, None)


def blended(weight, sizes, us, least, patience) -> Any:
    """(N,) fraction that is kept, and the best corrections (N, n), after the last of the runs."""
    ends = [last_of(column, least, patience) for column in sizes.T]
    best = us[0]
    for k in range(1, len(us)):
        better = [
            sizes[k, i] < sizes[:k, i].min() and (end is None or k <= end)
            for i, end in enumerate(ends)
        ]
        new = np.diag(weight[:, better].sum(axis=1))
        best = new @ us[k] + (np.eye(len(new)) - new) @ best
    return weight[:, [end is not None for end in ends]].sum(axis=1), best


@cases(5)
@given(
    shape=MOTORS_AND_ORDER,
    n_samples=LENGTH,
    segments=st.integers(1, 5),
    patience=st.integers(1, 3),
    least=st.sampled_from([0.02, 0.1, 0.4]),
    slowest=SLOWEST,
    damping=DAMPING,
    seed=SEED,
)
def test_learning_by_segment_is_that_of_its_matrices(
    shape, n_samples, segments, patience, least, slowest, damping, seed
):
    """Eight runs; segments that stall keep their best correction, the others learn on."""
    rng, (n, order) = np.random.default_rng(seed), shape
    n_samples = min(n_samples, LONGEST // n)
    T = random_matrix(rng, n, order, slowest, damping)
    if not T.is_stable:
        return
    edges = np.linspace(0, n_samples, segments + 1).astype(int)
    centres = 0.5 * (edges[1:] + edges[:-1])
    weight = np.stack([np.interp(range(n_samples), centres, i) for i in np.eye(segments)], axis=1)
    judged = tuple(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))
    law = BySegment(
        law=LAW,
        weight=weight,
        judged=judged,
        size_of=lambda e: np.abs(e).max(axis=1),
        least=least,
        patience=patience,
    )
    (L, Q), G = matrices(n_samples, n), dense(T, n_samples)
    e_0 = by_column([low_pass(n_samples, 10.0)] * n) @ rng.standard_normal(n * n_samples)
    u, memory = np.zeros((n_samples, n)), None
    us, sizes = [], []
    for _ in range(8):
        e = e_0 - G @ u.ravel() + 0.01 * rng.standard_normal(u.size)
        us.append(u)
        largest = np.abs(e.reshape(u.shape)).max(axis=1)
        sizes.append([np.sqrt(np.square(largest[i:j]).sum()) for i, j in judged])
        kept, best = blended(weight, np.array(sizes), us, least, patience)
        learned = (Q @ (u.ravel() + L @ e)).reshape(u.shape)
        expected = np.diag(1.0 - kept) @ learned + np.diag(kept) @ best
        u, memory = law.step(u, e.reshape(u.shape), memory)
        assert close(u, expected, np.linalg.norm(us[-1]))
