"""A cut: constant speed around the contour, rest at both ends, limits reported."""

import numpy as np
import pytest

from armside.sim.cell import LARGE_ROBOT_POSES, TOOL_QUATERNION, pose
from armside.sim.motion.contour import Circle
from armside.sim.motion.path import CuttingPath, Plane
from armside.sim.motion.timing import PathLimits
from armside.sim.motion.tool_motion import cut

RADIUS = 0.005


def a_cut(speed=0.04, **options):
    path = CuttingPath.around(Circle(RADIUS), Plane(pose("p1").position))
    return cut(path, TOOL_QUATERNION, speed, **options)


@pytest.mark.parametrize("speed", [0.01, 0.04, 0.06, 0.08, 0.1])
def test_speed_is_constant_over_exactly_one_turn(speed):
    motion = a_cut(speed)
    first, last = motion.contour_time
    t = np.linspace(first, last, 500)
    _, v, a = motion.timing.at(t - motion.rest_before)
    np.testing.assert_allclose(v, motion.reached_speed, rtol=1e-9)
    np.testing.assert_allclose(a, 0.0, rtol=0, atol=1e-9)
    assert (last - first) * motion.reached_speed == pytest.approx(2 * np.pi * RADIUS, rel=1e-12)
    np.testing.assert_allclose(
        motion.position_at(first), motion.position_at(last), rtol=0, atol=1e-12
    )


def test_samples_lie_on_the_programmed_circle_and_at_the_log_rate():
    motion = a_cut()
    centre = np.array(pose("p1").position)
    radius = np.linalg.norm(motion.position - centre, axis=1)
    np.testing.assert_allclose(radius, RADIUS, rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.diff(motion.time), 0.004, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(motion.position_at(motion.time), motion.position)
    np.testing.assert_array_equal(motion.is_on_contour(motion.time), motion.on_contour)
    assert motion.on_contour.sum() == 196  # 0.7854 s / 4 ms


def test_the_tool_rests_before_and_after_for_the_time_asked_for():
    motion = a_cut(rest_before=0.28, rest_after=0.35)
    at_rest = np.all(motion.position == motion.position[0], axis=1)
    assert np.all(at_rest[:71])  # 70 intervals of 4 ms
    assert not at_rest[72]
    moving = np.flatnonzero(np.any(np.diff(motion.position, axis=0) != 0, axis=1))
    assert motion.time[-1] - motion.time[moving[-1] + 1] >= 0.35 - 1e-12


def test_centripetal_acceleration_caps_the_speed_and_is_reported():
    motion = a_cut(0.1)
    assert motion.programmed_speed == 0.1
    assert motion.reached_speed == pytest.approx(np.sqrt(1.3 * RADIUS))
    assert [(name, axis) for name, axis, _ in motion.limits_hit] == [
        ("centripetal_acceleration", 0)
    ]
    assert a_cut(0.08).limits_hit == ()


def test_acceleration_along_the_path_is_reported_where_it_limits():
    limits = PathLimits(acceleration=0.5, jerk=100.0)
    motion = a_cut(0.04, limits=limits)
    ((name, axis, first),) = motion.limits_hit
    assert (name, axis) == ("path_acceleration", 0)
    assert first == pytest.approx(motion.rest_before + 0.5 / 100.0)


def test_leads_are_lengthened_only_where_the_ramp_needs_it():
    assert a_cut(0.04).path.lead_in == pytest.approx(0.1 * 2 * np.pi * RADIUS)
    fast = a_cut(0.08)
    assert fast.path.lead_in == pytest.approx(PathLimits().ramp_length(0.08))


def test_the_orientation_is_constant_and_of_unit_length():
    motion = a_cut()
    assert np.all(motion.quaternion == motion.quaternion[0])
    assert np.linalg.norm(motion.quaternion[0]) == pytest.approx(1.0, abs=1e-15)


def test_a_motion_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        a_cut().position[0] = 0.0


@pytest.mark.parametrize("speed", [0.0, -0.04, np.nan])
def test_a_speed_that_is_not_positive_is_named(speed):
    with pytest.raises(ValueError, match="speed must be > 0"):
        a_cut(speed)


def test_an_unknown_pose_names_those_that_exist():
    with pytest.raises(ValueError, match=r"Unknown pose 'p9'\. Poses: p1, p2, p3"):
        pose("p9")


def test_the_thesis_quaternion_is_normalised_and_points_the_tool_forward():
    printed = np.array([0.6322, 0.0353, 0.7732, 0.0353])
    assert np.linalg.norm(printed) == pytest.approx(1.000004, abs=5e-7)
    np.testing.assert_allclose(TOOL_QUATERNION, printed, rtol=0, atol=5e-6)
    for where in LARGE_ROBOT_POSES.values():
        assert np.linalg.norm(where.tool_axis) == pytest.approx(1.0, abs=1e-15)
        assert where.tool_axis[0] > 0.97
