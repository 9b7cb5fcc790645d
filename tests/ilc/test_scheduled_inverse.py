"""The regularised inverse of a plant that varies along the trajectory."""

import numpy as np
import pytest
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse
from armside.ilc.models.system import Complex


class Gain:
    """A plant of one input and one output that is a gain."""

    def __init__(self, gain: float) -> None:
        self.gain = gain

    def response(self, omega: ArrayLike) -> Complex:
        return np.full((len(np.atleast_1d(omega)), 1, 1), self.gain, dtype=np.complex128)


def inverse(gain: float) -> RegularisedInverse:
    shared = {"sample_time": 0.004, "cutoff": 10.0, "output_weight": (1.0,), "input_size": (1.0,)}
    return RegularisedInverse(G=Gain(gain), gamma=1.0, regularisation=1e-6, **shared)


N = 500
TIME: Array = np.arange(N, dtype=np.float64) * 0.004
HUMP: Array = np.sin(np.pi * TIME / TIME[-1])[:, None] ** 2


def test_with_one_place_it_is_the_regularised_inverse():
    law = ScheduledInverse(laws=(inverse(2.0),), weights=np.ones((N, 1)))
    start = 0.1 * HUMP
    assert law(start, HUMP) == pytest.approx(inverse(2.0)(start, HUMP), abs=2e-3)


def test_each_place_is_inverted_by_its_own_law():
    late = np.interp(TIME, [0.4, 1.6], [0.0, 1.0])
    weights = np.stack((1.0 - late, late), axis=1)
    law = ScheduledInverse(laws=(inverse(1.0), inverse(4.0)), weights=weights)
    u = law(np.zeros_like(HUMP), HUMP)[:, 0]
    assert u[50] == pytest.approx(HUMP[50, 0], abs=0.02)
    assert u[-50] == pytest.approx(HUMP[-50, 0] / 4.0, abs=0.02)


def test_weights_that_are_none_are_refused():
    with pytest.raises(ValueError, match="sum 1"):
        ScheduledInverse(laws=(inverse(1.0),), weights=np.full((N, 1), 0.5))
    with pytest.raises(ValueError, match="cover 500 samples"):
        ScheduledInverse(laws=(inverse(1.0),), weights=np.ones((N, 1))).check(400, 1)
