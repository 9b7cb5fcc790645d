"""Weights of the places along a way."""

import numpy as np
import pytest

from armside.sim.estimation.way.law import fading


def test_weights_fade_between_centres_and_have_the_sum_one():
    time = np.arange(0.0, 2.0, 0.004)
    weights = fading(np.array([0.0, 1.0, 1.5]), time)
    assert weights.sum(axis=1) == pytest.approx(np.ones(len(time)))
    assert weights[125] == pytest.approx([0.5, 0.5, 0.0])
    assert weights[-1] == pytest.approx([0.0, 0.0, 1.0])
