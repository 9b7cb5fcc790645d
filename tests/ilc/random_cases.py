"""Random plants for tests against dense references, and settings of hypothesis for them."""

import os
from typing import Any, NamedTuple

import numpy as np
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

from .signals import T_S

AGREED = 1e-6
"""Largest difference from a reference, relative to the size of the reference."""


def close(found, expected, size=0.0):
    return np.linalg.norm(found - expected) <= AGREED * max(np.linalg.norm(expected), size)


SEED = st.integers(0, 10**6)
ORDER = st.integers(1, 14)
SLOWEST = st.sampled_from([0.7, 0.9, 0.97, 0.995])
DAMPING = st.sampled_from([0.5, 0.05, 5e-3, 1e-4])
LENGTH = st.sampled_from([50, 51, 160, 400] + ([2000] if os.environ.get("ARMSIDE_CI") else []))
SHORT = st.sampled_from([50, 51, 120])
LONGEST = 2000
"""Samples of all motors together: the size of a dense matrix."""
MOTORS_AND_ORDER = st.sampled_from([(1, 1), (1, 6), (1, 14), (2, 4), (3, 3), (6, 1)])
ONE_MOTOR = st.tuples(st.just(1), ORDER)


ALL_CHECKS: Any = HealthCheck


def cases(number):
    """Settings for so many examples: the same ones in every run, or many more in CI."""
    return settings(
        max_examples=number * (10 if os.environ.get("ARMSIDE_CI") else 1),
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=[*ALL_CHECKS],
        phases=[Phase.explicit, Phase.generate],
    )


def random_poles(rng, order, slowest, damping):
    """Real poles below `slowest`, pairs with at least `damping`."""
    poles = []
    while len(poles) < order:
        if len(poles) + 2 <= order and rng.random() < 0.5:
            omega = rng.uniform(0.05, 2.8)
            pole = np.exp(omega * (-np.exp(rng.uniform(np.log(damping), 0.0)) + 1j))
            poles += [pole, pole.conjugate()]
        else:
            poles.append(rng.uniform(0.4, slowest))
    return np.array(poles)


def random_system(rng, order, slowest, damping):
    """The largest gain is about 1."""
    poles = random_poles(rng, order, slowest, damping)
    a: Any = np.poly(poles).real
    b = np.concatenate((np.zeros(rng.integers(0, 4)), rng.standard_normal(order)))
    gain = np.abs(System(b, a, T_S).response(np.angle(poles))).max()
    return System(b / gain, a, T_S)


def random_matrix(rng, n, *shape):
    """A system, or a matrix of systems that all differ."""
    rows = tuple(tuple(random_system(rng, *shape) for _ in range(n)) for _ in range(n))
    return rows[0][0] if n == 1 else SystemMatrix(rows)


def drawn(seed, shape, *poles) -> Any:
    """Generator, plant of (motors, order), motors, and that it is stable."""
    rng = np.random.default_rng(seed)
    T = random_matrix(rng, *shape, *poles)
    return rng, T, shape[0], T.is_stable


class Case(NamedTuple):
    """A stable plant with the generator that drew it."""

    rng: Any
    T: Any
    n: int
    """Motors."""
    n_samples: int


@st.composite
def stable(draw, shapes, lengths, slowest, damping):
    rng, shape = np.random.default_rng(draw(SEED)), draw(shapes)
    T = random_matrix(rng, *shape, draw(slowest), draw(damping))
    assume(T.is_stable)
    return Case(rng, T, shape[0], min(draw(lengths), LONGEST // shape[0]))


def on_plants(
    examples, shapes=MOTORS_AND_ORDER, lengths=LENGTH, slowest=SLOWEST, damping=DAMPING, **more
):
    """Decorator: a test of so many cases, and of what else is drawn by name."""
    return lambda test: cases(examples)(
        given(case=stable(shapes, lengths, slowest, damping), **more)(test)
    )


def random_state_matrix(rng, order, slowest, damping):
    """A with such poles, in coordinates that are neither modes nor orthogonal."""
    A, i = np.zeros((order, order)), 0
    for pole in random_poles(rng, order, slowest, damping):
        if pole.imag == 0.0:
            A[i, i], i = pole.real, i + 1
        elif pole.imag > 0.0:
            A[i : i + 2, i : i + 2] = [[pole.real, pole.imag], [-pole.imag, pole.real]]
            i += 2
    T = np.eye(order) + 0.5 * rng.standard_normal((order, order)) / np.sqrt(order)
    return T @ A @ np.linalg.inv(T)


def entries_of(T):
    return T.entries if isinstance(T, SystemMatrix) else ((T,),)


def dense(T, n_samples, taps=(1.0,)):
    """F T by scipy's recursion, (N n, N n), samples first, motors within a sample."""
    entries = entries_of(T)
    n = len(entries)
    full = np.zeros((n_samples, n, n_samples, n))
    for i, row in enumerate(entries):
        for j, system in enumerate(row):
            h = lfilter(taps, [1.0], lfilter(system.b, system.a, np.eye(n_samples)[0]))
            full[:, i, :, j] = toeplitz(h, np.zeros(n_samples))
    return full.reshape(n_samples * n, n_samples * n)


def dense_states(A, B, C, D, taps=(1.0,)):
    """F T of matrices along the record, (N, ., .) each: products of A, sample by sample."""
    n_samples, p, m = D.shape
    full = np.zeros((n_samples, p, n_samples, m))
    for s in range(n_samples):
        full[s, :, s] = D[s]
        state = B[s]
        for t in range(s + 1, n_samples):
            full[t, :, s] = C[t] @ state
            state = A[t] @ state
    seen: Any = lfilter(taps, [1.0], full, axis=0)
    return seen.reshape(n_samples * p, n_samples * m)
