"""Timing goes from rest to rest and keeps every limit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armside.sim.motion.timing import PathLimits, rest_to_rest


@settings(deadline=None, max_examples=50)
@given(length=st.floats(1e-3, 1.0), speed=st.floats(1e-3, 1.0))
def test_every_limit_is_kept_over_the_whole_length(length, speed):
    limits = PathLimits()
    timing = rest_to_rest(length, speed, limits)
    t = np.linspace(0.0, timing.duration, 2001)
    s, v, a = timing.at(t)
    assert s[0] == 0.0
    assert s[-1] == pytest.approx(length, rel=1e-9)
    assert np.max(v) <= speed * (1 + 1e-9)
    assert np.min(v) >= -1e-9
    assert np.max(np.abs(a)) <= limits.acceleration * (1 + 1e-9)
    jerk = np.abs(np.diff(a[1:-1])) / (t[1] - t[0])
    assert np.max(jerk) <= limits.jerk * (1 + 1e-6)


def test_speed_and_acceleration_are_the_derivatives_of_the_arc_length():
    timing = rest_to_rest(0.0377, 0.04, PathLimits())
    h = 1e-5
    t = np.linspace(0.003, timing.duration - 0.003, 400)
    before, now, after = timing.at(t - h), timing.at(t), timing.at(t + h)
    np.testing.assert_allclose(now[1], (after[0] - before[0]) / (2 * h), rtol=0, atol=1e-8)
    np.testing.assert_allclose(now[2], (after[1] - before[1]) / (2 * h), rtol=0, atol=1e-4)


def test_before_and_after_the_motion_the_tool_rests():
    timing = rest_to_rest(0.0377, 0.04, PathLimits())
    s, v, a = timing.at([-1.0, 0.0, timing.duration, 10.0])
    np.testing.assert_allclose(s, [0.0, 0.0, 0.0377, 0.0377], rtol=1e-9)
    np.testing.assert_array_equal(v, 0.0)
    np.testing.assert_array_equal(a, 0.0)


def test_the_default_ramp_to_40_mm_per_s_lasts_120_ms():
    limits = PathLimits()
    start, _ = rest_to_rest(0.0377, 0.04, limits).cruise
    assert start == pytest.approx(0.120, rel=1e-9)
    assert limits.ramp_length(0.04) == pytest.approx(0.04 * 0.120 / 2, rel=1e-12)


@pytest.mark.parametrize("speed", [0.01, 0.04, 0.1, 0.5])
def test_the_ramp_length_is_where_constant_speed_begins(speed):
    limits = PathLimits()
    timing = rest_to_rest(3 * limits.ramp_length(speed), speed, limits)
    s, v, _ = timing.at(timing.cruise[0])
    assert s == pytest.approx(limits.ramp_length(speed), rel=1e-9)
    assert v == pytest.approx(speed, rel=1e-9)


def test_a_path_too_short_never_reaches_the_speed():
    limits = PathLimits()
    timing = rest_to_rest(limits.ramp_length(0.04), 0.04, limits)
    assert timing.top_speed < 0.04
    assert timing.cruise[0] == timing.cruise[1]


@pytest.mark.parametrize("speed", [0.0, -1.0, np.nan])
def test_a_speed_that_is_not_positive_is_named(speed):
    with pytest.raises(ValueError, match="speed must be > 0"):
        rest_to_rest(1.0, speed, PathLimits())


def test_limits_must_be_positive():
    with pytest.raises(ValueError, match="jerk must be > 0"):
        PathLimits(jerk=0.0)
