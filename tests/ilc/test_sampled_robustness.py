"""Robustness by sampled plants: interval of the fraction, and known fractions."""

import numpy as np
import pytest
from scipy.stats import binom, binomtest

from armside.ilc.analysis.robustness import fraction_interval, sampled_robustness
from armside.ilc.filters import ALL_PASS
from armside.ilc.laws import Heuristic
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System


@pytest.mark.parametrize(("held", "n"), [(0, 5), (5, 5), (1, 20), (13, 40), (999, 1000)])
@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.99])
def test_the_interval_is_that_of_clopper_and_pearson(held, n, confidence):
    expected = binomtest(held, n).proportion_ci(confidence, method="exact")
    np.testing.assert_allclose(fraction_interval(held, n, confidence), expected, rtol=1e-9)


@pytest.mark.parametrize("n", [20, 100])
@pytest.mark.parametrize("fraction", [0.3, 0.8, 0.9])
def test_intervals_of_95_percent_cover_the_fraction_at_least_as_often(n, fraction):
    """Exactly, over all outcomes; the interval is conservative, never too narrow."""
    inside = 0.0
    for held in range(n + 1):
        low, high = fraction_interval(held, n)
        inside += float(binom.pmf(held, n, fraction)) * (low < fraction < high)
    assert 0.95 <= inside <= 0.99


def test_59_plants_that_converge_speak_for_95_percent():
    plants = [System(np.ones(1), np.ones(1), 0.01)] * 59
    law = Heuristic(Q=ALL_PASS, gamma=0.5, delta=0)
    assert sampled_robustness(plants, law, 5).at_least() == pytest.approx(0.05 ** (1 / 59))
    assert 0.95 < 0.05 ** (1 / 59)


def test_gains_above_two_do_not_converge():
    """|1 - gain| < 1 for the static plant; coupled: for its largest singular value."""
    gains = np.random.default_rng(0).uniform(0.5, 3.0, 40)
    law = Heuristic(Q=ALL_PASS, gamma=1.0, delta=0)
    single = [System(np.array([gain]), np.ones(1), 0.01) for gain in gains]
    found = sampled_robustness(single, law, 6)
    np.testing.assert_allclose(found.contraction, np.abs(1.0 - gains), rtol=1e-6, atol=1e-9)
    assert found.fraction == (gains < 2.0).mean()
    assert found.at_least() < found.fraction
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    state = np.zeros((1, 1)), np.zeros((1, 2)), np.zeros((2, 1))
    coupled = [StateSpace(*state, np.eye(2) + gain * turn) for gain in gains]
    pairs = sampled_robustness(coupled, law, 6, 2)
    np.testing.assert_allclose(pairs.contraction, gains, rtol=1e-6)


def test_nothing_to_judge_is_refused():
    with pytest.raises(ValueError, match="plants must not be empty"):
        sampled_robustness([], Heuristic(Q=ALL_PASS), 10)
    with pytest.raises(ValueError, match="held must be 0 to n and n >= 1, got 3 of 2"):
        fraction_interval(3, 2)
