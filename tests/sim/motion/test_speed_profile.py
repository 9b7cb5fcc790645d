"""Profiles are as fast as asked wherever limits allow, and keep each limit everywhere."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from armside.sim.motion.profile_grid import nearly_at_rest
from armside.sim.motion.profile_program import LimitRows, Programme, largest, stacked
from armside.sim.motion.speed_profile import Bends, _first_grid, profiles
from armside.sim.motion.timing import PathLimits, rest_to_rest
from armside.sim.part import plan as plan_module
from armside.sim.part.arcs import line
from armside.sim.part.drawing import DrawnChain
from armside.sim.part.part import part_of

LIMITS = PathLimits()
R = 5e-3
QUARTER = 0.5 * np.pi * R
LENGTHS = np.array([0.145, QUARTER, 0.070, QUARTER, 0.290, QUARTER, 0.070, QUARTER, 0.145])
"""The outline of 300 x 80 mm with corners of 5 mm [m]."""
CURVATURE = np.array([0.0, 1.0 / R] * 4 + [0.0])


def profile(lengths, curvature, speed):
    return profiles([Bends(lengths, curvature)], speed, LIMITS)[0]


def straight(speed):
    return profile(np.array([0.2]), np.array([0.0]), speed)


@pytest.fixture(scope="module")
def outline():
    return profile(LENGTHS, CURVATURE, 0.167)


def derivatives(timing, h):
    """Finite differences of s(t) up to the third, by h [s]."""
    s = timing.at(np.arange(0.0, timing.duration, h))[0]
    return s, [np.diff(s, k) / h**k for k in (1, 2, 3)]


def test_the_speed_that_is_asked_for_is_reached_on_the_straights(outline):
    """At least 95 % of the length that ramps leave, each ramp as if it began at the corner."""
    corner = np.sqrt(LIMITS.acceleration * R)
    _, ramp = change_of(corner, 0.167)
    rest = LIMITS.ramp_length(0.167)
    possible = (0.290 - 2 * ramp) + 2 * (0.145 - ramp - rest) + 2 * max(0.0, 0.070 - 2 * ramp)
    fast = outline.speed[:-1] >= 0.999 * 0.167
    reached = np.diff(outline.s)[fast].sum()
    assert reached >= 0.95 * possible


def test_no_limit_is_exceeded(outline):
    s, (v, a, j) = derivatives(outline.timing, 1e-3)
    assert v.max() <= 1.001 * 0.167
    assert np.abs(a).max() <= 1.01 * LIMITS.acceleration
    assert np.abs(j).max() <= 1.01 * LIMITS.jerk
    middle = 0.5 * (s[1:] + s[:-1])
    element = np.clip(np.searchsorted(np.cumsum(LENGTHS), middle), 0, len(LENGTHS) - 1)
    assert (v**2 * CURVATURE[element]).max() <= 1.01 * LIMITS.acceleration


def test_a_profile_is_of_the_whole_path_from_rest_to_rest(outline):
    assert outline.s[[0, -1]] == pytest.approx([0.0, LENGTHS.sum()])
    assert (np.diff(outline.s) >= 0.0).all()
    assert outline.speed[[0, -1]].tolist() == [0.0, 0.0]
    timing = outline.timing
    s, v, a = timing.at([0.0, timing.duration])
    np.testing.assert_allclose(s, [0.0, LENGTHS.sum()], atol=1e-9)
    np.testing.assert_allclose([*v, *a], 0.0, atol=1e-9)
    end = timing.at(timing.duration * (1.0 - 1e-9))
    np.testing.assert_allclose(end[1:], 0.0, atol=1e-5)


@pytest.mark.parametrize("speed", [0.02, 0.08, 0.3])
def test_on_a_straight_line_it_is_nearly_as_fast_as_the_fastest_timing(speed):
    found = straight(speed)
    best = rest_to_rest(0.2, speed, LIMITS)
    assert best.duration <= found.timing.duration * (1.0 + 1e-6)
    assert found.timing.duration <= 1.05 * best.duration


def test_a_speed_that_is_none_is_refused():
    with pytest.raises(ValueError, match="speed must be > 0 m/s, got 0"):
        straight(0.0)


def test_paths_that_are_solved_together_have_the_profiles_of_each_alone():
    lengths = [np.array([0.05, 0.5 * np.pi * r, 0.08]) for r in (1e-3, 3e-3, 9e-3)]
    bends = [np.array([0.0, 1.0 / r, 0.0]) for r in (1e-3, 3e-3, 9e-3)]
    together = profiles([Bends(a, b) for a, b in zip(lengths, bends, strict=True)], 0.1, LIMITS)
    for found, a, b in zip(together, lengths, bends, strict=True):
        alone = profile(a, b, 0.1)
        np.testing.assert_allclose(found.speed, alone.speed, atol=1e-7)


def test_the_interior_point_method_finds_the_optimum_of_another_solver():
    """A random path: rows of three points, upper bounds, and two points held at each end."""
    rng = np.random.default_rng(3)
    n = 200
    caps, held = rng.uniform(0.2, 1.0, n), np.zeros(n, dtype=bool)
    held[[0, 1, -2, -1]] = True
    x = np.full(n, 0.02)
    one, inside = np.ones(n), ~held
    bend = np.where(np.isin(np.arange(n), (0, n - 1)), np.inf, 0.004)
    slope = np.where(np.isin(np.arange(n), (0, n - 2, n - 1)), np.inf, 0.03)
    rows = [
        LimitRows(0 * one, one, 0 * one, np.where(inside, caps, np.inf)),
        LimitRows(0 * one, -one, 0 * one, np.where(inside, 0.0, np.inf)),
        LimitRows(0 * one, -one, one, slope),
        LimitRows(0 * one, one, -one, slope),
        LimitRows(one, -2 * one, one, bend),
        LimitRows(-one, 2 * one, -one, bend),
    ]
    found, solved = largest(Programme.of(stacked(rows), np.array([0]), held), x)
    assert solved.all()
    A, b = [], []
    for row in rows:
        dense = np.diag(row.middle) + np.diag(row.lower[1:], -1) + np.diag(row.upper[:-1], 1)
        real = np.isfinite(row.bound)
        A.append(dense[real])
        b.append(row.bound[real])
    bounds = [(0.02, 0.02) if h else (None, None) for h in held]
    best = linprog(-one, A_ub=np.vstack(A), b_ub=np.concatenate(b), bounds=bounds)
    assert found.sum() == pytest.approx(-best.fun, rel=1e-7)
    assert (np.vstack(A) @ found <= np.concatenate(b) + 1e-7).all()


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
    found = profile(lengths, curvature, speed)
    assert found.timing.duration <= 1.3 * simple_time(lengths, curvature, speed)
    assert limits_used(found, lengths, curvature) <= 1.01
    assert found.speed.max() <= 1.01 * speed
    assert len(found.rests) == 0


def test_a_plan_that_rests_within_a_contour_is_refused_with_its_place(monkeypatch):
    """The profiles of the plan are given a rest 20 mm along the path of a triangle."""

    def rested(*asked):
        return [replace(one, rests=np.array([0.02])) for one in profiles(*asked)]

    monkeypatch.setattr(plan_module, "profiles", rested)
    part = part_of([DrawnChain(line((0, 0), (0.05, 0), (0.05, 0.05), (0, 0)), "one", "")])
    with pytest.raises(ValueError, match=r"moving at \(.*\) mm, 20.0 mm along the path; try"):
        plan_module.plan(part)


def test_a_rest_between_bends_is_seen_and_slow_bends_are_none():
    lengths, curvature = bent(0.1e-3, np.array([0.06, 0.06]), (1,))
    grid = _first_grid(Bends(lengths, curvature), 0.167, LIMITS)
    held = np.full(len(grid.s), np.sqrt(LIMITS.acceleration * 0.1e-3))
    assert not nearly_at_rest(grid, held**2).any()
    held[125] = 0.1 * held[125]
    assert np.flatnonzero(nearly_at_rest(grid, held**2)).tolist() == [125]
