"""Norm-optimal steps beside a dense or scipy reference on random cases: agree or refuse.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4. A refusal is an error that says
so; a result that differs is a failure. CI tries ten times as many cases.
"""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion

from .random_cases import AGREED, DAMPING, SEED, SLOWEST, cases, dense, random_matrix


@cases(8)
@given(
    shape=st.sampled_from([(1, 14), (2, 9), (3, 6), (4, 4), (5, 3), (6, 3)]),
    fraction=st.floats(0.0, 1.0),
    slowest=SLOWEST,
    damping=DAMPING,
    weight=st.sampled_from([1e-2, 1e-4, 1e-6]),
    varying=st.booleans(),
    taps=st.sampled_from([(1.0,), (1.0, -0.8)]),
    seed=SEED,
)
def test_a_norm_optimal_step_is_the_least_squares_solution(
    shape, fraction, slowest, damping, weight, varying, taps, seed
):
    rng = np.random.default_rng(seed)
    n, order = shape[0], max(1, round(fraction * shape[1]))
    n_samples = max(50, 300 // n)
    T = random_matrix(rng, n, order, slowest, damping)
    u, e = rng.standard_normal((2, n_samples, n))
    size = (n_samples, n) if varying else ()
    We, Wu, Wd = (np.exp(rng.uniform(-1, 1, size)) * w for w in (1.0, weight, 10 * weight))
    criterion = QuadraticCriterion(error=We, correction=Wu, change=Wd, error_filter=taps)
    try:
        law = NormOptimal(T_u=T, n_samples=n_samples, n_columns=n, criterion=criterion)
        ours = law(u, e)
    except (ValueError, RuntimeError) as refused:
        assert "is unstable" in str(refused) or "known to" in str(refused)  # noqa: PT017
        return
    We, Wu, Wd = (np.broadcast_to(w, (n_samples, n)).ravel() for w in (We, Wu, Wd))
    G = np.sqrt(We)[:, None] * dense(T, n_samples, taps)
    stacked = np.vstack((G, np.diag(np.sqrt(Wu)), np.diag(np.sqrt(Wd))))
    F_e: Any = lfilter(taps, [1.0], e, axis=0)
    right = (np.sqrt(We) * F_e.ravel(), -np.sqrt(Wu) * u.ravel())
    step = np.linalg.lstsq(stacked, np.concatenate((*right, np.zeros(u.size))))[0]
    expected = u.ravel() + step
    assert np.linalg.norm(ours.ravel() - expected) <= AGREED * np.linalg.norm(expected)
