"""Profiles are as fast as asked wherever limits allow, and keep each limit everywhere."""

import numpy as np
import pytest

from armside.sim.cut.speed_profile import profile
from armside.sim.cut.timing import PathLimits, rest_to_rest

LIMITS = PathLimits()
R = 5e-3
QUARTER = 0.5 * np.pi * R
LENGTHS = np.array([0.145, QUARTER, 0.070, QUARTER, 0.290, QUARTER, 0.070, QUARTER, 0.145])
"""The outline of 300 x 80 mm with corners of 5 mm [m]."""
CURVATURE = np.array([0.0, 1.0 / R] * 4 + [0.0])


@pytest.fixture(scope="module")
def outline():
    return profile(LENGTHS, CURVATURE, 0.167, LIMITS)


def derivatives(timing, h):
    """Finite differences of s(t) up to the third, by h [s]."""
    s = timing.at(np.arange(0.0, timing.duration, h))[0]
    return s, [np.diff(s, k) / h**k for k in (1, 2, 3)]


def test_the_speed_that_is_asked_for_is_reached_on_the_straights(outline):
    """At least 95 % of the length that ramps leave, each ramp as if it began at the corner."""
    corner = np.sqrt(LIMITS.acceleration * R)
    rise = 0.167 - corner
    peak = min(LIMITS.acceleration, np.sqrt(LIMITS.jerk * rise))
    ramp = 0.5 * (0.167 + corner) * (rise / peak + peak / LIMITS.jerk)
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


def test_it_goes_from_rest_to_rest_over_the_whole_length(outline):
    timing = outline.timing
    s, v, a = timing.at([0.0, timing.duration])
    np.testing.assert_allclose(s, [0.0, LENGTHS.sum()], atol=1e-9)
    np.testing.assert_allclose([*v, *a], 0.0, atol=1e-9)
    end = timing.at(timing.duration * (1.0 - 1e-9))
    np.testing.assert_allclose(end[1:], 0.0, atol=1e-5)


@pytest.mark.parametrize("speed", [0.02, 0.08, 0.3])
def test_on_a_straight_line_it_is_nearly_as_fast_as_the_fastest_timing(speed):
    found = profile(np.array([0.2]), np.array([0.0]), speed, LIMITS)
    best = rest_to_rest(0.2, speed, LIMITS)
    assert best.duration <= found.timing.duration * (1.0 + 1e-6)
    assert found.timing.duration <= 1.05 * best.duration


def test_the_outline_takes_less_time_than_at_the_speed_of_its_corners(outline):
    slow = rest_to_rest(LENGTHS.sum(), np.sqrt(LIMITS.acceleration * R), LIMITS)
    assert outline.timing.duration < 0.65 * slow.duration


def test_a_speed_that_is_none_is_refused():
    with pytest.raises(ValueError, match="speed must be > 0 m/s, got 0"):
        profile(np.array([0.2]), np.array([0.0]), 0.0, LIMITS)
