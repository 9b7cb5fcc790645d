"""Speeds beside bends as small as the grid: close to the fastest, and never at rest on the way."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.motion.profile_grid import SLACK, resting
from armside.sim.motion.speed_profile import Bends, _first_grid, profile, profiles
from armside.sim.motion.timing import PathLimits
from armside.sim.part import plan as plan_module
from armside.sim.part.chain import line
from armside.sim.part.drawing import Joined
from armside.sim.part.part import part_of

LIMITS = PathLimits()
RADII = (0.1e-3, 0.25e-3, 0.4e-3, 0.7e-3, 1.2e-3, 2e-3)


def bent(radius, straights, signs):
    """Lengths and curvature of straights with quarter circles between them, to either side."""
    lengths, curvature = [straights[0]], [0.0]
    for sign, straight in zip(signs, straights[1:], strict=True):
        lengths += [0.5 * np.pi * radius, straight]
        curvature += [sign / radius, 0.0]
    return np.array(lengths), np.array(curvature)


def change_of(slow, fast):
    """Time and length of the change between two speeds at the limits of acceleration and jerk."""
    peak = min(LIMITS.acceleration, np.sqrt(LIMITS.jerk * (fast - slow)))
    time = (fast - slow) / peak + peak / LIMITS.jerk
    return time, 0.5 * (slow + fast) * time


def straight_time(length, before, after, speed):
    """From one speed to another over a straight, as fast as `speed` where there is room."""
    lowest, highest = max(before, after), speed
    for _ in range(50):
        fast = 0.5 * (lowest + highest)
        room = length - change_of(before, fast)[1] - change_of(after, fast)[1]
        lowest, highest = (fast, highest) if room >= 0.0 else (lowest, fast)
    up, down = change_of(before, lowest), change_of(after, lowest)
    return up[0] + down[0] + max(0.0, length - up[1] - down[1]) / lowest


def simple_time(lengths, curvature, speed):
    """Each bend at the speed that its radius allows, changes of speed on the straights alone."""
    bends = np.abs(curvature[1::2])
    corner = np.minimum(speed, np.sqrt(LIMITS.acceleration / bends))
    ends = np.concatenate([[0.0], corner, [0.0]])
    straights = zip(lengths[::2], ends[:-1], ends[1:], strict=True)
    return (lengths[1::2] / corner).sum() + sum(straight_time(*each, speed) for each in straights)


def limits_used(found, lengths, curvature):
    """Largest acceleration along and across, and jerk, of their limits."""
    t = np.arange(0.0, found.timing.duration, 2e-4)
    s, v, a = found.timing.at(t)
    element = np.clip(np.searchsorted(np.cumsum(lengths), s), 0, len(lengths) - 1)
    across = np.abs(curvature[element]) * v**2
    jerk = np.abs(found.timing.state[:, 3]).max() / LIMITS.jerk
    return max(np.abs(a).max() / LIMITS.acceleration, across.max() / LIMITS.acceleration, jerk)


@pytest.mark.parametrize("speed", [0.08, 0.167])
@pytest.mark.parametrize("radius", RADII)
def test_small_bends_to_either_side_cost_no_more_than_their_own_speed(radius, speed):
    straights = np.array([0.06, 0.039, 0.009, 0.059, 0.024, 0.05])
    lengths, curvature = bent(radius, straights, (1, -1, 1, 1, -1))
    found = profile(lengths, curvature, speed, LIMITS)
    assert found.timing.duration <= 1.3 * simple_time(lengths, curvature, speed)
    assert limits_used(found, lengths, curvature) <= 1.01
    assert found.speed.max() <= 1.01 * speed
    assert len(found.rests) == 0


def test_a_plan_that_rests_within_a_contour_is_refused_with_its_place(monkeypatch):
    """The profiles of the plan are given a rest 20 mm along the path of a triangle."""

    def rested(*asked):
        return [replace(one, rests=np.array([0.02])) for one in profiles(*asked)]

    monkeypatch.setattr(plan_module, "profiles", rested)
    part = part_of([Joined(line((0, 0), (0.05, 0), (0.05, 0.05), (0, 0)), ("one",), "")])
    with pytest.raises(ValueError, match=r"moving at \(.*\) mm, 20.0 mm along the path; try"):
        plan_module.plan(part)


def test_a_rest_between_bends_is_seen_and_slow_bends_are_none():
    lengths, curvature = bent(0.1e-3, np.array([0.06, 0.06]), (1,))
    grid = _first_grid(Bends(lengths, curvature), 0.167, LIMITS)
    held = np.full(len(grid.s), np.sqrt(LIMITS.acceleration * 0.1e-3))
    assert not resting(grid, held**2, SLACK).any()
    held[125] = 0.1 * held[125]
    assert np.flatnonzero(resting(grid, held**2, SLACK)).tolist() == [125]
