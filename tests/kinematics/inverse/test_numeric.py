"""Numeric inverse kinematics: any serial robot, poses and positions, limits, paths, failures."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from tests.benchmarks._arms import PANDA, PANDA_LIMITS, PUMA_560, STANFORD_ARM, STANFORD_LIMITS

from armside.kinematics import (
    IRB1400,
    IRB1400_LIMITS,
    LARGE_ROBOT,
    LARGE_ROBOT_LIMITS,
    Joint,
    Limits,
    Link,
    NotConvergedError,
    Robot,
    compile,
    inverse_numeric,
    inverse_numeric_path,
)
from armside.kinematics.inverse import numeric, numeric_kernel

ARMS = [
    (PUMA_560, None),
    (STANFORD_ARM, STANFORD_LIMITS),
    (PANDA, PANDA_LIMITS),
    (IRB1400, IRB1400_LIMITS),
    (LARGE_ROBOT, LARGE_ROBOT_LIMITS),
]
TOLERANCE = 1e-9  # [m] and [rad], the default
PLANAR = Robot([Link(a=0.5), Link(a=0.4)], name="planar arm")


def name(value) -> str:
    return value.name if isinstance(value, Robot) else ""


def configurations(robot: Robot, limits: Limits | None, count: int) -> np.ndarray:
    """Random configurations within the limits."""
    lower, upper = (limits.lower, limits.upper) if limits else (-np.pi, np.pi)
    phi = np.random.default_rng(0).uniform(lower, upper, (2 * count, robot.n_joints))
    return phi[:count] if limits is None else phi[limits.contain(phi)][:count]


@pytest.mark.parametrize(("robot", "limits"), ARMS, ids=name)
def test_a_thousand_random_poses_are_all_solved_within_the_limits(robot, limits):
    """To the default tolerance, poses near singularities included."""
    ends = (limits.lower, limits.upper) if limits else (-np.pi, np.pi)
    start, phi = (np.random.default_rng(m).uniform(*ends, (m, robot.n_joints)) for m in (1, 1000))
    phi = phi if limits is None else phi[limits.contain(phi)]
    T = compile(robot).pose(phi)
    found = inverse_numeric(robot, T, start[0], limits=limits)
    np.testing.assert_allclose(compile(robot).pose(found), T, rtol=0, atol=2 * TOLERANCE)
    assert limits is None or limits.contain(found).all()


@pytest.mark.parametrize(("bend", "restarts"), [(1e-3, 0), (1e-4, 0), (1e-6, 100), (0.0, 100)])
def test_an_arm_that_is_nearly_stretched_is_solved(bend, restarts):
    """A descent of the error creeps along a curved valley there, and ended at 1e-8 to 1e-6 m.

    Closer to the singularity several solutions meet: some starts end above the tolerance.
    """
    stretched = np.pi - np.arctan2(0.4318, 0.0203)  # forearm and offset in line with the upper arm
    phi = np.array([-0.3, -0.2, stretched + bend, 1.0, 0.6, -2.7])
    assert np.linalg.svd(compile(PUMA_560).jacobian(phi))[1][-1] < bend / 100 + 1e-15
    T = compile(PUMA_560).pose(phi)
    for start in phi + np.random.default_rng(0).uniform(-0.3, 0.3, (50, 6)):
        found = inverse_numeric(PUMA_560, T, start, restarts=restarts)
        np.testing.assert_allclose(compile(PUMA_560).pose(found), T, rtol=0, atol=2 * TOLERANCE)


@pytest.mark.parametrize(("robot", "limits"), ARMS, ids=name)
def test_a_single_pose_is_a_batch_of_one(robot, limits):
    T = compile(robot).pose(configurations(robot, limits, 3))
    start = np.full(robot.n_joints, 0.1)
    batch = inverse_numeric(robot, T, start, limits=limits)
    for k in range(3):
        alone = inverse_numeric(robot, T[k], start, limits=limits)
        np.testing.assert_allclose(alone, batch[k], rtol=0, atol=1e-12)


@pytest.mark.parametrize(("robot", "limits"), ARMS, ids=name)
def test_a_position_leaves_the_axes_of_the_tool_free(robot, limits):
    phi = configurations(robot, limits, 50)
    p = compile(robot).pose(phi)[:, :3, 3]
    found = inverse_numeric(robot, p, phi[0], limits=limits)
    np.testing.assert_allclose(compile(robot).pose(found)[:, :3, 3], p, rtol=0, atol=TOLERANCE)
    turned = compile(robot).pose(found)[:, :3, :3] - compile(robot).pose(phi)[:, :3, :3]
    assert np.abs(turned).max() > 0.1


def test_the_branch_of_the_start_is_kept():
    """A start within 0.05 rad of a regular configuration leads back to it."""
    phi = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    for robot in (IRB1400, LARGE_ROBOT, PUMA_560):
        T = compile(robot).pose(phi)
        np.testing.assert_allclose(inverse_numeric(robot, T, phi + 0.05), phi, rtol=0, atol=1e-7)
        turned = phi + 2 * np.pi * np.array([1, 0, 0, 0, 0, -1])
        found = inverse_numeric(robot, T, turned + 0.05)
        np.testing.assert_allclose(found, turned, rtol=0, atol=1e-7)


def test_the_nearest_of_all_branches_is_chosen():
    """Among eight branches, by the closed form, of the start far from all of them."""
    from armside.kinematics import inverse_nearest

    T = compile(LARGE_ROBOT).pose(np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4]))
    for start in np.random.default_rng(1).uniform(-2, 2, (10, 6)):
        expected = inverse_nearest(LARGE_ROBOT, T, start)
        found = inverse_numeric(LARGE_ROBOT, T, start, nearest=True, restarts=300)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)


def test_limits_choose_another_branch_or_refuse():
    T = compile(LARGE_ROBOT).pose(np.radians([10, 20, 0, 200, 40, -250]))
    start = np.radians([0, 0, 0, -120, 0, 0])
    found = inverse_numeric(LARGE_ROBOT, T, start, limits=LARGE_ROBOT_LIMITS)
    assert LARGE_ROBOT_LIMITS.contain(found)
    narrow = Limits(lower=(-0.1,) * 6, upper=(0.1,) * 6, speed=(1.0,) * 6)
    with pytest.raises(NotConvergedError, match="beyond the joint limits only") as caught:
        inverse_numeric(LARGE_ROBOT, T, start, limits=narrow)
    assert caught.value.distance == 0


@pytest.mark.parametrize("turns", [(3, -2, 4, 2, -5, 7), (-2, 3, -3, -7, 2, 2)])
def test_a_start_whole_turns_beyond_the_limits_hides_no_solution(turns):
    """Solutions within the limits are refused for no start, by neither solver."""
    from armside.kinematics import UR10, inverse_nearest

    phi = np.array([0.5, -1.0, 1.0, 0.3, 0.7, 0.2])
    limits = Limits(lower=(-np.pi,) * 6, upper=(np.pi,) * 6, speed=(1.0,) * 6)
    high = replace(limits, lower=(4 * np.pi,) * 6, upper=(6 * np.pi,) * 6)
    T, far = compile(UR10).pose(phi), phi + 2 * np.pi * np.array(turns)
    for start, ranges in ((far, limits), (far, high), (phi, high)):
        for found in (
            inverse_nearest(UR10, T, start, ranges),
            inverse_numeric(UR10, T, start, limits=ranges),
            inverse_numeric(UR10, T, start, limits=ranges, nearest=True),
        ):
            assert ranges.contain(found)
            np.testing.assert_allclose(compile(UR10).pose(found), T, rtol=0, atol=TOLERANCE)


def test_a_coupled_range_is_kept():
    phi = configurations(IRB1400, None, 300)
    T = compile(IRB1400).pose(phi)
    for pose in T:
        try:
            found = inverse_numeric(IRB1400, pose, np.zeros(6), limits=IRB1400_LIMITS)
        except NotConvergedError:
            continue
        assert IRB1400_LIMITS.contain(np.round(found, 8))


@pytest.mark.parametrize(("robot", "limits"), ARMS, ids=name)
def test_a_path_is_followed_without_jumps(robot, limits):
    phi = configurations(robot, limits, 2)
    along = phi[0] + 0.2 * (phi[1] - phi[0]) * np.linspace(0, 1, 1000)[:, None]
    T = compile(robot).pose(along)
    path = inverse_numeric_path(robot, T, along[0])
    np.testing.assert_allclose(compile(robot).pose(path), T, rtol=0, atol=2 * TOLERANCE)
    assert np.abs(np.diff(path, axis=0)).max() < 0.02
    if robot.n_joints == 6:
        np.testing.assert_allclose(path, along, rtol=0, atol=1e-6)


def test_a_redundant_arm_moves_least():
    """Each step has no part in the null space of the Jacobian, to first order."""
    phi = configurations(PANDA, PANDA_LIMITS, 2)
    along = phi[0] + 0.1 * (phi[1] - phi[0]) * np.linspace(0, 1, 1000)[:, None]
    path = inverse_numeric_path(PANDA, compile(PANDA).pose(along), along[0])
    J = compile(PANDA).jacobian((path[1:] + path[:-1]) / 2)
    step = np.diff(path, axis=0)
    null = np.linalg.svd(J)[2][:, -1]
    part = np.abs((null * step).sum(-1)) / np.linalg.norm(step, axis=-1)
    assert np.median(part) < 1e-3


def test_arms_with_fewer_joints_solve_what_they_reach():
    phi = np.array([0.3, 0.9])
    T = compile(PLANAR).pose(phi)
    np.testing.assert_allclose(inverse_numeric(PLANAR, T, [0.2, 0.5]), phi, rtol=0, atol=1e-8)
    p = T[:3, 3]
    found = inverse_numeric(PLANAR, p, [1.0, -0.5])
    np.testing.assert_allclose(found[1], -0.9, rtol=0, atol=1e-8)
    T[2, 3] = 0.1  # above the plane
    with pytest.raises(NotConvergedError) as caught:
        inverse_numeric(PLANAR, T, phi)
    assert caught.value.distance == pytest.approx(0.1, rel=1e-3)


def test_half_a_turn_of_the_tool_is_no_obstacle():
    for axis in np.eye(3):
        T = compile(LARGE_ROBOT).pose(np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4]))
        target = T.copy()
        target[:3, :3] = Rotation.from_rotvec(np.pi * axis).as_matrix() @ T[:3, :3]
        found = inverse_numeric(LARGE_ROBOT, target, [0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
        np.testing.assert_allclose(compile(LARGE_ROBOT).pose(found), target, rtol=0, atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(phi=st.tuples(*[st.floats(-3, 3)] * 6).map(np.array))
def test_error_is_the_motion_to_the_target(phi):
    """Against SciPy's rotation vector."""
    T, target = compile(LARGE_ROBOT).pose(np.stack([phi, phi[::-1]]))
    error = np.empty(6)
    square = numeric_kernel._error(T, target, 6, error)
    turn = Rotation.from_matrix(target[:3, :3] @ T[:3, :3].T).as_rotvec()
    opposite = np.abs(np.linalg.norm(turn) - np.pi) < 1e-6 and turn @ error[3:] < 0
    expected = [*(target - T)[:3, 3], *(-turn if opposite else turn)]
    np.testing.assert_allclose(error, expected, rtol=0, atol=1e-6)
    assert square == pytest.approx(error @ error)


@pytest.mark.parametrize("n", [1, 2, 5, 8])
def test_kernel_has_the_pose_and_jacobian_of_the_generated_code(n, random_robot, interpreted):
    """Any joints, constant links, coupling and both conventions: see `make_robot`."""
    from armside.kinematics import Convention
    from armside.kinematics.equations import forward_kinematics

    rng = np.random.default_rng(n)
    for convention in Convention:
        robot, phi = random_robot(rng, n, convention), rng.uniform(-1, 1, n)
        links, joints, prismatic, M, offset, coupled = numeric._chain(robot)[0]
        axes, T = np.empty((n, 6)), np.eye(4)
        columns, J = np.empty((6, n)), np.empty((6, n))
        numeric_kernel._forward(links, joints, M, offset, phi, axes, T)
        free = np.full(n, -1.0), np.ones(n)
        numeric_kernel._jacobian(prismatic, M, coupled, axes, T, columns, *free, J)
        expected = interpreted(forward_kinematics.pose(robot))(phi)
        np.testing.assert_allclose(T, expected, rtol=0, atol=1e-13)
        expected = interpreted(forward_kinematics.jacobian(robot))(phi)
        np.testing.assert_allclose(J, expected, rtol=0, atol=1e-13)


def test_a_wrist_that_is_not_spherical_is_solved():
    links = list(LARGE_ROBOT.links)
    links[3] = replace(links[3], a=0.05)
    robot = Robot(links, offset=LARGE_ROBOT.offset)
    phi = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    T = compile(robot).pose(phi)
    found = inverse_numeric(robot, T, start=phi + 0.3)
    np.testing.assert_allclose(compile(robot).pose(found), T, rtol=0, atol=1e-9)


def test_failure_says_what_remains_where():
    T = np.eye(4)
    T[0, 3] = 10.0
    with pytest.raises(NotConvergedError, match=r"mm and .* deg remain at phi = \[") as caught:
        inverse_numeric(LARGE_ROBOT, T, start=np.full(6, 0.1))
    reached = compile(LARGE_ROBOT).pose(caught.value.phi)
    remains = np.linalg.norm(reached[:3, 3] - T[:3, 3])
    assert caught.value.distance == pytest.approx(remains, rel=1e-9)


REFUSED = [
    ({"T": np.eye(4) * np.nan}, "T must be finite"),
    ({"T": [np.nan, 0, 0]}, "T must be finite"),
    ({"T": 2 * np.eye(4)}, "rigid motions"),
    ({"T": np.diag([1.0, 1.0, -1.0, 1.0])}, "rigid motions"),
    ({"T": np.eye(3)[None, None]}, r"got \(1, 1, 3, 3\)"),
    ({"start": np.zeros(5)}, r"start must have shape \(6,\), got \(5,\)"),
    ({"start": [np.inf] * 6}, "start must be finite"),
    *(({"restarts": x}, "restarts must be a whole number from 0") for x in (-1, 1.5, None)),
    ({"robot": Robot([Link(a="a")]), "start": [0.0]}, "of numbers; robot has symbols: a"),
    ({"robot": PANDA, "start": [0.0] * 7, "limits": IRB1400_LIMITS}, "have 7 motors, got 6"),
]


@pytest.mark.parametrize(("given", "complaint"), REFUSED, ids=range(len(REFUSED)))
def test_bad_targets_starts_and_options_are_refused(given, complaint):
    usual = {"robot": LARGE_ROBOT, "T": np.eye(4), "start": np.zeros(6)}
    with pytest.raises(ValueError, match=complaint):
        inverse_numeric(**(usual | given))


@pytest.mark.parametrize("tolerance", [-1e-9, 0.0, np.nan, np.inf, 1e-14, "1e-9", None, [1e-9]])
def test_a_tolerance_that_no_search_can_keep_is_refused(tolerance):
    """Below 1e-12 an error is not reduced: 1e-14 left the branch of its start."""
    phi = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    T = compile(LARGE_ROBOT).pose(phi)
    said = r"tolerance must be a number from 1e-12 \[m and rad\]"
    for solve, target in ((inverse_numeric, T), (inverse_numeric_path, T[None])):
        with pytest.raises(ValueError, match=said):
            solve(LARGE_ROBOT, target, phi + 0.1, tolerance)


def test_a_slide_stays_in_its_range_on_the_way():
    robot = Robot([Link(joint=Joint.PRISMATIC), Link(a=0.3)])
    limits = Limits(lower=(0.0, -3.0), upper=(1.0, 3.0), speed=(1.0, 1.0))
    T = compile(robot).pose([0.9, 2.0])
    found = inverse_numeric(robot, T, [0.0, -1.0], limits=limits)
    np.testing.assert_allclose(found, [0.9, 2.0], rtol=0, atol=1e-9)
