"""One turn of the contour is counted once: its start belongs to it, its end to what follows."""

import numpy as np
import pytest

from armside.sim.cell import TOOL_QUATERNION
from armside.sim.motion.contour import Circle
from armside.sim.motion.path import CuttingPath, Plane
from armside.sim.motion.timing import PathLimits
from armside.sim.motion.tool_motion import cut

STEP = 0.004  # [s], of the log
CENTRE = np.array([1.3166, 0.0014, 1.5992])


def motion(radius=0.005, speed=0.040):
    path = CuttingPath.around(Circle(radius), Plane(CENTRE))
    return cut(path, TOOL_QUATERNION, speed)


def test_the_first_instant_of_a_turn_belongs_to_it_and_its_last_does_not():
    m = motion()
    first, last = m.contour_time
    assert last - first == pytest.approx(2 * np.pi * 0.005 / 0.040)
    times = np.array([np.nextafter(first, 0), first, np.nextafter(last, 0), last])
    assert m.is_on_contour(times).tolist() == [False, True, True, False]
    # both ends are the same point of the contour: counted once
    start, end = m.position_at(first), m.position_at(last)
    assert start == pytest.approx(end, abs=1e-9)


def on_samples(n):
    """Motion whose turn of n samples begins and ends on samples, to rounding."""
    path = CuttingPath.around(Circle(0.040 * n * STEP / (2 * np.pi)), Plane(CENTRE))
    first, _ = cut(path, TOOL_QUATERNION, 0.040).contour_time
    wait = np.ceil(first / STEP) * STEP - first
    return cut(path, TOOL_QUATERNION, 0.040, rest_before=0.28 + wait)


def test_samples_at_the_ends_of_a_turn_are_counted_once():
    """Of turns that end on a sample exactly there are some among those that do to rounding."""
    exact = 0
    for n in range(150, 200):
        m = on_samples(n)
        _, last = m.contour_time
        assert not m.on_contour[m.time == last].any()
        assert np.array_equal(m.on_contour, m.is_on_contour(m.time))
        exact += np.count_nonzero(m.time == last)
    assert exact > 0


def test_the_motion_has_the_rests_and_the_limits_of_the_calibrated_record():
    """0.16 s of hold and 0.12 s of rest before, 0.35 s after; 81 mm/s on a circle of 5 mm."""
    m = motion()
    assert m.rest_before == pytest.approx(0.28)
    moving = np.flatnonzero(np.abs(np.diff(m.arc_length)) > 0.0)
    assert m.time[moving[0]] == pytest.approx(0.28, abs=0.004)
    assert m.time[-1] - m.time[moving[-1] + 1] == pytest.approx(0.35, abs=0.008)
    limits = PathLimits()
    assert limits.acceleration == 1.3
    assert motion(speed=0.2).reached_speed == pytest.approx(np.sqrt(1.3 * 0.005))
    ramp = 2.0 * np.sqrt(0.040 / limits.jerk)
    assert ramp == pytest.approx(0.120)
