"""Timing of one curve whose limits vary along it."""

import numpy as np
import pytest

from armside.sim.motion.move_timing import VaryingLimits, averaged, fastest

PLACES = 201
JERK_TIME = 0.05
W = np.linspace(0.0, 1.0, PLACES)


def bounds(speed, acceleration, bend=0.0):
    """One axis with a speed limit and an acceleration limit at each place."""
    ones = np.ones(PLACES)
    along = np.zeros((PLACES, 7))
    along[:, 0] = 1.0 / (acceleration * ones)
    bends = np.zeros((PLACES, 7))
    bends[:, 0] = bend
    return VaryingLimits(speed=speed * ones, along=along, bend=bends)


def sampled(timing, n=5000):
    t = np.linspace(0.0, timing.duration, n)
    return t, *timing.at(t)


def test_under_constant_limits_the_duration_is_that_of_two_ramps_and_the_jerk_time():
    timing = fastest(bounds(speed=100.0, acceleration=9.0), JERK_TIME)
    assert timing.duration == pytest.approx(2.0 * np.sqrt(1.0 / 9.0) + JERK_TIME, rel=1e-3)
    assert np.abs(timing.state[:, 3]).max() <= 2.0 * 9.0 / JERK_TIME * (1 + 1e-6)


def test_it_rests_at_the_end():
    timing = fastest(bounds(speed=1.0 + W, acceleration=9.0), JERK_TIME)
    _, w, v, a = sampled(timing)
    assert w[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-9)
    assert v[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert np.all(np.diff(w) >= 0.0)
    assert np.abs(a).max() <= 9.0


def test_speed_and_acceleration_are_the_derivatives_of_the_parameter():
    t, w, v, a = sampled(fastest(bounds(speed=2.0 - W, acceleration=9.0), JERK_TIME))
    assert np.gradient(w, t)[5:-5] == pytest.approx(v[5:-5], abs=2e-3)
    assert np.gradient(v, t)[5:-5] == pytest.approx(a[5:-5], abs=0.1)


def test_it_is_slow_only_where_it_must_be():
    narrow = 1.0 - 0.9 * np.exp(-(((W - 0.5) / 0.05) ** 2))
    slow = bounds(speed=narrow, acceleration=9.0)
    timing = fastest(slow, JERK_TIME)
    _, w, v, _ = sampled(timing)
    assert np.all(v <= np.interp(w, W, slow.speed) * (1 + 1e-3))
    assert v.max() > 5.0 * narrow.min()
    whole = fastest(bounds(speed=narrow.min(), acceleration=9.0), JERK_TIME)
    assert timing.duration < 0.5 * whole.duration


def test_following_a_bend_uses_part_of_the_acceleration():
    bent = bounds(speed=2.0, acceleration=9.0, bend=0.15)
    _, _, v, a = sampled(fastest(bent, JERK_TIME))
    assert np.all(0.15 * v**2 + np.abs(a) / 9.0 <= 1.0 + 1e-3)


def test_a_moving_average_leaves_a_steady_speed_as_it_is():
    x = np.minimum(np.minimum(0.5 * W * 8.0, 0.5 * (1.0 - W) * 8.0), 1.0)
    _, _, v, _ = sampled(averaged(x, JERK_TIME))
    assert v.max() == pytest.approx(1.0, rel=1e-9)
