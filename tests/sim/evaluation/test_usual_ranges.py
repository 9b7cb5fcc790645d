"""Usual ranges of arms scale with reach, and hold the arms that they come from."""

import pytest

from armside.sim.evaluation.usual_ranges import USUAL

TWICE = {"reach": 1, "mass": 8, "holding": 1, "acceleration": 0.5, "lowest_mode": 0.5, "gear": 1}
"""Factor of an arm of twice the reach: mass with its cube, accelerations and modes against it."""


@pytest.mark.parametrize("name", USUAL)
def test_an_arm_of_twice_the_reach_has_a_range_that_follows(name):
    low, high = USUAL[name].range(1.0)
    assert 0.0 < low < high
    assert USUAL[name].range(2.0) == pytest.approx((TWICE[name] * low, TWICE[name] * high))


@pytest.mark.parametrize(
    ("name", "reach", "values"),
    [
        ("reach", 1.0, (0.58, 1.44, 2.8)),
        ("mass", 1.44, (225.0,)),
        ("mass", 0.58, (25.0,)),
        ("holding", 1.0, (0.3, 0.6)),
        ("acceleration", 2.0, (6.5, 65.0)),
        ("lowest_mode", 2.0, (5.5, 10.5)),
        ("gear", 1.0, (60.0, 243.0)),
    ],
)
def test_arms_that_the_ranges_come_from_lie_within(name, reach, values):
    low, high = USUAL[name].range(reach)
    assert all(low <= value <= high for value in values)
