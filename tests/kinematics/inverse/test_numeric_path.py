"""Numeric inverse kinematics along a path: residual, limits, continuity, cause of an end, time."""

import time

import numpy as np
import pytest
from tests.benchmarks._arms import CIRCLES, PANDA, PANDA_LIMITS, circle

from armside.kinematics import (
    LARGE_ROBOT,
    LARGE_ROBOT_LIMITS,
    CoupledRange,
    Limits,
    NotConvergedError,
    compile,
    inverse_numeric_path,
    inverse_path,
)
from armside.kinematics.inverse.targets import Cause, limit_passed

RESIDUAL = 1e-9
SEVEN = np.array(CIRCLES[1][2])


on_circles = pytest.mark.parametrize(("robot", "limits", "start"), CIRCLES, ids=["six", "seven"])


def ends(robot, T, start, limits=None) -> NotConvergedError:
    with pytest.raises(NotConvergedError) as caught:
        inverse_numeric_path(robot, T, start, limits=limits)
    return caught.value


@on_circles
def test_a_circle_is_followed_within_the_limits_and_without_jumps(robot, limits, start):
    T = circle(robot, start)
    path = inverse_numeric_path(robot, T, start, limits=limits)
    np.testing.assert_allclose(compile(robot).pose(path), T, rtol=0, atol=RESIDUAL)
    assert limits.contain(path).all()
    assert np.abs(np.diff(path, axis=0)).max() < 0.01
    np.testing.assert_allclose(path[0], start, rtol=0, atol=1e-8)


@on_circles
def test_a_thousand_poses_of_a_circle_take_less_than_5_ms(robot, limits, start):
    """Time of the processor, the least of ten: a busy machine only adds to it."""
    T, least = circle(robot, start), np.inf
    for _ in range(10):
        begin = time.process_time()
        inverse_numeric_path(robot, T, start, limits=limits)
        least = min(least, time.process_time() - begin)
    assert least < 5e-3


def test_the_branch_is_that_of_the_closed_form():
    start = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    T = circle(LARGE_ROBOT, tuple(start), 300)
    expected = inverse_path(LARGE_ROBOT, T, start, LARGE_ROBOT_LIMITS)
    found = inverse_numeric_path(LARGE_ROBOT, T, start, limits=LARGE_ROBOT_LIMITS)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_a_redundant_arm_keeps_a_limit_that_its_least_motion_would_pass():
    T = circle(PANDA, tuple(SEVEN), 400)
    free = inverse_numeric_path(PANDA, T, SEVEN)
    lower, upper = np.array(PANDA_LIMITS.lower), np.array(PANDA_LIMITS.upper)
    upper[2] = free[:, 2].max() - 0.3 * np.ptp(free[:, 2])
    limits = Limits(lower=tuple(lower), upper=tuple(upper), speed=PANDA_LIMITS.speed)
    assert not limits.contain(free).all()
    path = inverse_numeric_path(PANDA, T, SEVEN, limits=limits)
    assert limits.contain(path).all()
    np.testing.assert_allclose(compile(PANDA).pose(path), T, rtol=0, atol=RESIDUAL)
    assert (path[:, 2] == upper[2]).sum() > 10
    assert np.abs(np.diff(path, axis=0)).max() < 0.05


def test_a_limit_in_the_way_is_named_with_its_motor():
    phi = np.zeros((20, 6))
    phi[:, 4] = np.linspace(0.3, 0.6, 20)
    narrow = Limits(lower=(-3.0,) * 6, upper=(3.0,) * 4 + (0.5, 3.0), speed=(1.0,) * 6)
    error = ends(LARGE_ROBOT, compile(LARGE_ROBOT).pose(phi), phi[0], narrow)
    assert (error.index, error.cause) == (13, Cause.LIMIT)
    assert "motor 5 would be at 0.5053, and its range is -3.0000 to 0.5000" in str(error)


def test_a_coupled_range_in_the_way_is_named():
    bound = CoupledRange(coefficients=(0, -1, 1), lower=-1.0, upper=1.0)
    limits = Limits(lower=(-9.0,) * 3, upper=(9.0,) * 3, speed=(1.0,) * 3, coupled=(bound,))
    assert limit_passed(np.array([0.0, 0.2, 1.0]), limits) is None
    passed = limit_passed(np.array([0.0, 0.2, 1.5]), limits)
    assert passed == "-1 phi_2 +1 phi_3 would be 1.3000, and its range is -1.0000 to 1.0000"


def test_the_reach_is_named_with_the_distance():
    T = np.repeat(compile(PANDA).pose(SEVEN)[None], 50, axis=0)
    T[:, 0, 3] += np.linspace(0, 2, 50)
    error = ends(PANDA, T, SEVEN)
    assert error.cause is Cause.REACH
    assert 0 < error.distance <= 2 / 49
    k = error.index
    assert f"target {k} of 50" in str(error)
    assert inverse_numeric_path(PANDA, T[:k], SEVEN).shape == (k, 7)
    assert "mm and" in str(error)


def test_a_jump_through_a_singularity_is_refused_with_its_joint():
    """A straight line of the tool past the axis of joint 1, where that joint turns half a turn."""
    start = np.array([0.0, -0.3, 0.2, 0.0, 0.8, 0.0])
    T = np.repeat(compile(LARGE_ROBOT).pose(start)[None], 2, axis=0)
    turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    T[1] = turn @ T[0]
    error = ends(LARGE_ROBOT, T, start)
    assert (error.index, error.cause) == (1, Cause.SINGULARITY)
