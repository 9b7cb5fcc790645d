"""Inverse kinematics in closed form: theorems, the poses of chapter 9, and every refusal."""

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from tests.benchmarks._arms import PUMA_560

from armside.kinematics import (
    IRB1400,
    IRB1400_IMU,
    LARGE_ROBOT,
    LARGE_ROBOT_LIMITS,
    Convention,
    Joint,
    Limits,
    Link,
    NotConvergedError,
    Robot,
    Singularity,
    UnreachableError,
    UnsolvableGeometryError,
    compile,
    inverse_branches,
    inverse_nearest,
    inverse_numeric,
    inverse_path,
)

HALF = np.pi / 2
# The same kind of arm with everything that the two robots lack: shoulder offset, skew first axis,
# turned-over second axis, links before and after, a coupling that is no integer, theta offsets.
ODD = Robot(
    [
        Link(theta=0.3, d=0.2, a=0.1, alpha=0.4, joint=Joint.FIXED),
        Link(theta=0.1, d=0.5, a=0.2, alpha=1.1),
        Link(theta=-0.2, d=0.15, a=0.7, alpha=np.pi),
        Link(theta=0.4, d=-0.05, a=0.1, alpha=0.8),
        Link(d=0.6, alpha=-HALF),
        Link(theta=0.2, alpha=HALF),
        Link(d=0.1, a=0.05, alpha=0.3),
        Link(theta=0.5, d=0.02, a=0.03, alpha=0.7, joint=Joint.FIXED),
    ],
    coupling=np.eye(6) + np.diag([0, 0.3, 0, -0.25, 0.5], -1),
    offset=[0.1, -0.4, 0.2, 0, 0.3, 0.6],
    name="odd arm",
)
MODIFIED = Robot(
    [
        Link(d=0.4, alpha=0.2),
        Link(a=0.1, alpha=-HALF),
        Link(a=0.5),
        Link(d=0.45, a=0.05, alpha=-HALF),
        Link(alpha=HALF),
        Link(d=0.08, alpha=-HALF),
    ],
    convention=Convention.MODIFIED,
    name="modified arm",
)
# The upper arm and the forearm point backwards at theta 0.
BACKWARD = Robot(
    [replace(link, a=-link.a) if i in (1, 2) else link for i, link in enumerate(ODD.links, -1)],
    ODD.coupling,
    ODD.offset,
    name="backward arm",
)
ROBOTS = [IRB1400, IRB1400_IMU, LARGE_ROBOT, ODD, MODIFIED, PUMA_560, BACKWARD]
angle = st.floats(-3.1, 3.1)
configuration = st.tuples(*[angle] * 6).map(np.array)


def whole_turns(robot: Robot, difference: np.ndarray) -> np.ndarray:
    """Distance of joint-variable differences from a multiple of 2 pi."""
    q = difference @ robot.coupling.T
    return np.abs(q - 2 * np.pi * np.round(q / (2 * np.pi)))


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_every_branch_has_the_pose_and_one_is_where_it_came_from(robot):
    functions = compile(robot)
    phi = np.random.default_rng(3).uniform(-3, 3, (500, 6))
    T = functions.pose(phi)
    found = inverse_branches(robot, T)
    k, _ = np.nonzero(found.exists)
    np.testing.assert_allclose(functions.pose(found.phi[found.exists]), T[k], rtol=0, atol=1e-12)
    error = np.where(found.exists, whole_turns(robot, found.phi - phi[:, None]).max(-1), np.inf)
    assert error.min(axis=-1).max() < 1e-8  # a stretched elbow turns 1e-16 m into 1e-8 rad
    assert np.isnan(found.phi[~found.exists]).all()


@pytest.mark.parametrize("small", [0.0, 1e-15, 1e-12, 1e-11, 1e-9, 1e-7, 1e-4])
@pytest.mark.parametrize("joint", [3, 4])
def test_branches_hold_near_wrist_and_elbow_singularities(small, joint):
    """phi5 near 0 aligns axes 4 and 6; the forearm bent by atan(d4 / a3) stretches the elbow."""
    phi = np.array([0.3, 0.4, 0.2, 0.5, 0.7, -0.6])
    if joint == 4:
        phi[4] = small
    else:
        phi[2] = phi[1] - np.arctan2(0.72, 0.12) + np.pi / 2 - HALF + small
    functions = compile(IRB1400)
    T = functions.pose(phi)
    found = inverse_branches(IRB1400, T, reference=phi)
    assert found.exists.sum() >= 4
    np.testing.assert_allclose(functions.pose(found.phi[found.exists]) - T, 0, atol=1e-9)


def test_all_eight_branches_are_found_where_eight_exist():
    phi = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    found = inverse_branches(LARGE_ROBOT, compile(LARGE_ROBOT).pose(phi))
    assert found.exists.all()
    assert not found.singular.any()
    q = found.phi
    apart = [whole_turns(LARGE_ROBOT, q[i] - q[j]).max() for i in range(8) for j in range(i)]
    assert min(apart) > 0.1


def test_all_branches_agree_with_a_search_from_many_starts():
    """Every configuration that a numeric search finds is one of the eight."""
    rng = np.random.default_rng(5)
    T = compile(IRB1400).pose(np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4]))
    found = inverse_branches(IRB1400, T)
    hits = set()
    for start in rng.uniform(-np.pi, np.pi, (60, 6)):
        try:
            phi = inverse_numeric(IRB1400, T, start)
        except NotConvergedError:
            continue
        error = whole_turns(IRB1400, found.phi - phi).max(-1)
        assert np.nanmin(error) < 1e-6
        hits.add(int(np.nanargmin(error)))
    assert len(hits) >= 6


# Thesis (9.3), (9.4), and solutions of the IRB6600-2.55 in degrees, to the digits given.
POSES = {
    (1.3166, 0.0014, 1.5992): (0, -18.9, 36.7, -5.4, -6.4, 11.1),
    (1.8000, 0.1000, 1.5992): (3.5, 7.8, 12.4, 18.2, -9.2, -11.6),
    (2.2000, 0.2000, 1.5992): (5.6, 29.9, -16.4, 67.6, -5.4, -60.7),
}
QUATERNION = np.array([0.6322, 0.0353, 0.7732, 0.0353])


def pose_of_chapter_9(position: tuple[float, float, float]) -> np.ndarray:
    T = np.eye(4)
    unit = QUATERNION / np.linalg.norm(QUATERNION)
    T[:3, :3] = Rotation.from_quat(unit, scalar_first=True).as_matrix()
    T[:3, 3] = position
    return T


@pytest.mark.parametrize(("position", "degrees"), POSES.items())
def test_laser_poses_are_reached_as_known(position, degrees):
    T = pose_of_chapter_9(position)
    phi = inverse_nearest(LARGE_ROBOT, T, limits=LARGE_ROBOT_LIMITS)
    np.testing.assert_allclose(np.degrees(phi), degrees, rtol=0, atol=0.051)
    np.testing.assert_allclose(compile(LARGE_ROBOT).pose(phi), T, rtol=0, atol=1e-12)


def test_path_follows_one_branch_without_jumps():
    t = np.linspace(0, 4 * np.pi, 2000)
    T = np.repeat(pose_of_chapter_9((2.2, 0.2, 1.5992))[None], len(t), axis=0)
    T[:, 0, 3] += 0.005 * np.cos(t)
    T[:, 1, 3] += 0.005 * np.sin(t)
    phi = inverse_path(LARGE_ROBOT, T, limits=LARGE_ROBOT_LIMITS)
    np.testing.assert_allclose(compile(LARGE_ROBOT).pose(phi), T, rtol=0, atol=1e-12)
    assert np.abs(np.diff(phi, axis=0)).max() < 1e-3
    np.testing.assert_allclose(phi[1000 - 1 : 1001].mean(axis=0), phi[0], rtol=0, atol=1e-3)


def test_path_passes_whole_turns_and_the_wrist_singularity_without_jumps():
    phi = np.zeros((400, 6))
    phi[:, 5] = np.linspace(-5, 5, 400)  # beyond pi
    phi[:, 4] = np.linspace(-0.5, 0.51, 400)  # through 0
    phi[:, 1] = np.linspace(-0.3, 0.3, 400)
    T = compile(LARGE_ROBOT).pose(phi)
    np.testing.assert_allclose(inverse_path(LARGE_ROBOT, T, start=phi[0]), phi, rtol=0, atol=1e-9)


def test_path_starts_at_the_branch_nearest_to_the_start():
    phi = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    T = compile(IRB1400).pose(phi)[None]
    for branch in inverse_branches(IRB1400, T[0]).phi:
        if not np.isnan(branch).any():
            first = inverse_path(IRB1400, T, start=branch + 1e-3)[0]
            np.testing.assert_allclose(first, branch, rtol=0, atol=1e-14)


def test_free_angle_of_the_aligned_wrist_stays_where_it_was_and_is_reported():
    phi = np.array([0.3, 0.4, 0.2, 0.5, 0.0, -0.6])
    found = inverse_branches(LARGE_ROBOT, compile(LARGE_ROBOT).pose(phi), reference=phi)
    nearest = int(np.nanargmin(np.abs(found.phi - phi).max(-1)))
    assert found.singular[nearest] & Singularity.WRIST
    np.testing.assert_allclose(found.phi[nearest], phi, rtol=0, atol=1e-9)


def test_free_angle_of_the_shoulder_stays_where_it_was_and_is_reported():
    """The wrist centre of the arm is put on axis 1."""
    reference = np.array([0.7, 0, 0, 0, 0, 0])
    T = np.eye(4)
    T[:3, 3] = [0.0, 0.0, 0.780 + 1.0 + 0.2]
    found = inverse_branches(LARGE_ROBOT, T, reference)
    assert (found.singular[found.exists] & Singularity.SHOULDER).all()
    np.testing.assert_allclose(found.phi[found.exists][:, 0], 0.7, rtol=0, atol=1e-12)
    poses = compile(LARGE_ROBOT).pose(found.phi[found.exists])
    np.testing.assert_allclose(poses - T, 0, atol=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_singular_shoulder_with_an_offset_is_reported(side):
    """Puma 560 with its wrist centre as near to axis 1 as d3 allows: rank 5 and no flag before."""
    from scipy.optimize import brentq

    functions = compile(PUMA_560)

    def least(q2: float) -> float:
        return np.linalg.det(functions.jacobian([0.3, q2, 0.4, 0.5, 0.7, -0.6]))

    q2 = brentq(least, *((0.5, 2.5) if side > 0 else (-3.1, -2.0)), xtol=1e-15)
    phi = np.array([0.3, q2, 0.4, 0.5, 0.7, -0.6])
    assert np.linalg.svd(functions.jacobian(phi), compute_uv=False)[-1] < 1e-12
    found = inverse_branches(PUMA_560, functions.pose(phi), reference=phi)
    nearest = int(np.nanargmin(np.abs(found.phi - phi).max(-1)))
    assert found.singular[nearest] == Singularity.SHOULDER
    regular = inverse_branches(PUMA_560, functions.pose(phi + 0.1 * np.eye(6)[1]))
    assert not regular.singular.any()


def test_stretched_elbow_is_reported():
    phi = np.array([0.3, 0.4, 0, 0.5, 0.7, -0.6])
    phi[2] = -np.arctan2(1.142, 0.2)
    found = inverse_branches(LARGE_ROBOT, compile(LARGE_ROBOT).pose(phi))
    assert (found.singular[found.exists] & Singularity.ELBOW).any()


@pytest.mark.parametrize("beyond", [1e-6, 0.1, 3.0])
def test_unreachable_target_says_by_how_much(beyond):
    """Straight ahead at shoulder height, tool forward: reach is a1 + a2 + |(a3, d4)| + d6."""
    reach = 0.320 + 1.075 + np.hypot(0.200, 1.142) + 0.200
    T = compile(LARGE_ROBOT).pose(np.zeros(6))
    T[:3, 3] = [reach + beyond, 0, 0.780]
    with pytest.raises(UnreachableError, match="mm outside the workspace") as caught:
        inverse_branches(LARGE_ROBOT, np.stack([compile(LARGE_ROBOT).pose(np.zeros(6)), T]))
    assert caught.value.index == 1
    assert caught.value.distance == pytest.approx(beyond, rel=1e-6)


def test_edge_of_the_reach_is_reachable():
    T = compile(LARGE_ROBOT).pose(np.zeros(6))
    T[:3, 3] = [0.320 + 1.075 + np.hypot(0.200, 1.142) + 0.200, 0, 0.780]
    phi = inverse_nearest(LARGE_ROBOT, T)
    np.testing.assert_allclose(compile(LARGE_ROBOT).pose(phi), T, rtol=0, atol=1e-9)


def test_path_that_leaves_the_reach_says_where():
    T = np.repeat(compile(LARGE_ROBOT).pose(np.zeros(6))[None], 50, axis=0)
    T[:, 0, 3] += np.linspace(0, 3, 50)
    with pytest.raises(UnreachableError) as caught:
        inverse_path(LARGE_ROBOT, T)
    k = caught.value.index
    assert 0 < k < 50
    inverse_path(LARGE_ROBOT, T[:k])


def test_choice_respects_limits_and_uses_whole_turns():
    phi = np.radians([10, 20, 0, 200, 40, -250])
    T = compile(LARGE_ROBOT).pose(phi)
    chosen = inverse_nearest(LARGE_ROBOT, T, previous=phi, limits=LARGE_ROBOT_LIMITS)
    np.testing.assert_allclose(chosen, phi, rtol=0, atol=1e-9)
    narrow = np.radians([0, 0, 0, -120, 0, 0])
    other = inverse_nearest(LARGE_ROBOT, T, previous=narrow, limits=LARGE_ROBOT_LIMITS)
    assert LARGE_ROBOT_LIMITS.contain(other)


def test_target_beyond_the_limits_is_refused_in_words():
    narrow = Limits(lower=(-0.1,) * 6, upper=(0.1,) * 6, speed=(1.0,) * 6)
    phi = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    with pytest.raises(ValueError, match="limits must have 6 motors, got 5"):
        inverse_nearest(
            IRB1400, np.eye(4), phi, Limits(lower=(0,) * 5, upper=(1,) * 5, speed=(1,) * 5)
        )
    with pytest.raises(
        ValueError, match=r"all 8 branches are outside .*: in the best motor \d would"
    ):
        inverse_nearest(IRB1400, compile(IRB1400).pose(phi), phi, narrow)


def test_path_that_leaves_the_limits_says_where():
    phi = np.zeros((20, 6))
    phi[:, 4] = np.radians(np.linspace(90, 130, 20))
    with pytest.raises(
        ValueError, match=r"target 15 of 20 leaves .*: motor 5 would be at 2\.1220.*2\.0944"
    ):
        inverse_path(LARGE_ROBOT, compile(LARGE_ROBOT).pose(phi), phi[0], LARGE_ROBOT_LIMITS)


@pytest.mark.parametrize(
    ("T", "previous", "said"),
    [
        (np.full((4, 4), np.nan), None, "NaN"),
        (2 * np.eye(4), None, "rigid motions"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), None, "rigid motions"),
        (np.eye(4), [np.nan] * 6, "6 finite motor angles"),
        (np.eye(3), None, r"\(4, 4\) or \(N, 4, 4\)"),
    ],
)
def test_nan_and_what_is_no_rigid_motion_are_refused(T, previous, said):
    with pytest.raises(ValueError, match=said):
        inverse_nearest(LARGE_ROBOT, T, previous=previous)


def changed(index: int, **parameters) -> Robot:
    links = list(LARGE_ROBOT.links)
    links[index] = replace(links[index], **parameters)
    return Robot(links, offset=LARGE_ROBOT.offset)


@pytest.mark.parametrize(
    ("robot", "complaint"),
    [
        (changed(3, a=0.01), "the wrist is not spherical: a4 = 0.01 m"),
        (changed(4, d=0.02), "the wrist is not spherical: d5 = 0.02 m"),
        (changed(4, alpha=-1.0), "the wrist axes are not at right angles: alpha5"),
        (changed(1, alpha=0.1), "axes 2 and 3 are not parallel"),
        (changed(0, alpha=0.0), "axes 1 and 2 are parallel"),
        (changed(1, a=0.0), "upper arm or forearm has no length"),
        (changed(2, joint=Joint.PRISMATIC), "joint 3 is not revolute"),
        (Robot([Link()] * 5), "has 5 joints, not 6"),
    ],
)
def test_robots_of_another_kind_are_refused_with_the_fallback(robot, complaint):
    with pytest.raises(UnsolvableGeometryError, match=complaint) as caught:
        inverse_branches(robot, np.eye(4))
    assert "inverse_numeric" in str(caught.value)


def test_a_path_of_2000_targets_is_solved_within_15_ms():
    """5 ms on an idle core; three times that here."""
    T = compile(LARGE_ROBOT).pose(np.random.default_rng(0).uniform(-2, 2, (2000, 6)))
    times = []
    for _ in range(7):
        start = time.process_time()
        inverse_branches(LARGE_ROBOT, T)
        times.append(time.process_time() - start)
    assert np.median(times) < 15e-3
