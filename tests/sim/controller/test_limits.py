"""Targets at the very ends of what a joint may do."""

import numpy as np
import pytest

from armside.sim.controller.limits import STOPPING_TIME, GuidanceLimits

LIMITS = GuidanceLimits(
    lower=np.array([-1.0, -2.0]), upper=np.array([1.0, 3.0]), speed=np.array([2.0, 4.0])
)


@pytest.mark.parametrize(("axis", "end"), [(0, -1.0), (0, 1.0), (1, -2.0), (1, 3.0)])
def test_each_end_of_a_range_belongs_to_it_and_what_is_beyond_does_not(axis, end):
    target = np.zeros(2)
    target[axis] = end
    assert LIMITS.out_of_range(target) is None
    target[axis] = np.nextafter(end, 9.0 * end)
    assert f"axis {axis + 1} must be" in LIMITS.out_of_range(target)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("room", "share"), [(0.5, 1.0), (0.2, 1.0), (0.05, 0.5), (0.0, 0.0)])
def test_a_joint_is_as_fast_as_it_can_stop_within_its_room(side, room, share):
    """v^2 = 2 a s with a = 2 / 0.2 rad/s^2: its 2 rad/s need 0.2 rad, half of it a quarter."""
    assert STOPPING_TIME == 0.2
    target, step = np.array([side * (1.0 - room), 0.0]), 2.0 * share * LIMITS.period
    for factor, allowed in ((0.999, True), (1.001, share == 0.0)):
        before = target - [side * factor * step, 0.0]
        assert (LIMITS.too_fast(target, before) is None) == allowed


@pytest.mark.parametrize(("size", "allowed"), [(4.999, True), (5.001, False), (-5.001, False)])
def test_a_correction_is_at_most_five_degrees(size, allowed):
    refused = LIMITS.correction_refusal(np.deg2rad([0.0, size]))
    assert (refused is None) == allowed
