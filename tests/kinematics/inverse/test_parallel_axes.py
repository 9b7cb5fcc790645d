"""Closed-form inverse kinematics of arms whose axes 2, 3 and 4 are parallel."""

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armside.kinematics import (
    LARGE_ROBOT,
    UR10,
    UR10_LIMITS,
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
    inverse_numeric,
    inverse_path,
)
from armside.kinematics.robots import AUBO_I5

HALF = np.pi / 2
RESIDUAL = 1e-10  # [m] and [-], greatest deviation of a solution's pose, near singularities too


def universal_robot(name: str, d: list[float], a2: float, a3: float) -> Robot:
    d1, d4, d5, d6 = d
    rows = [Link(d=d1, alpha=HALF), Link(a=a2), Link(a=a3)]
    rows += [Link(d=d4, alpha=HALF), Link(d=d5, alpha=-HALF), Link(d=d6)]
    return Robot(rows, name=name)


# Universal Robots, support article "DH parameters for calculations of kinematics and dynamics".
UR5E = universal_robot("UR5e", [0.1625, 0.1333, 0.0997, 0.0996], -0.425, -0.3922)
UR3E = universal_robot("UR3e", [0.15185, 0.13105, 0.08535, 0.0921], -0.24355, -0.2132)


def drawn(seed: int, convention: Convention = Convention.STANDARD) -> Robot:
    """All lengths but a5 of either sign, any twist 1 and 6, links before and after, a coupling."""
    rng = np.random.default_rng(seed)
    d, a, theta = rng.uniform(-0.4, 0.4, (3, 8))
    a[2:4] = rng.choice([-1, 1], 2) * rng.uniform(0.3, 0.6, 2)
    a[5] = 0.0
    turned, square = rng.choice([0.0, np.pi, -np.pi], 2), rng.choice([HALF, -HALF], 2)
    alpha = [0.3, rng.choice([-1, 1]) * rng.uniform(0.4, 2.7), *turned, *square, 0.8, -0.5]
    if convention is Convention.MODIFIED:
        a, alpha = np.roll(a, 1), np.roll(alpha, 1)
    kinds = [Joint.FIXED, *[Joint.REVOLUTE] * 6, Joint.FIXED]
    rows = zip(theta, d, a, alpha, kinds, strict=True)
    coupling = np.eye(6) + np.diag(rng.uniform(-0.5, 0.5, 5), -1)
    offset = rng.uniform(-2, 2, 6)
    return Robot([Link(*row) for row in rows], coupling, offset, convention, f"drawn {seed}")


ROBOTS = [UR10, UR5E, UR3E, AUBO_I5, *map(drawn, range(8)), drawn(8, Convention.MODIFIED)]
GENERIC = np.array([0.3, -1.2, 0.9, 0.4, 1.1, -0.6])
"""Configuration of the UR10 with eight branches."""


def poses(robot: Robot, phi: np.ndarray) -> np.ndarray:
    """Products of the links' matrices, written out here: T (..., 4, 4) of phi (..., 6)."""
    T, values = np.eye(4), iter(np.moveaxis(robot.joint_variables(phi), -1, 0))
    for link in robot.links:
        theta = np.asarray(float(link.theta) + (next(values) if link.moves else 0.0))
        c, s, zero, one = np.cos(theta), np.sin(theta), 0 * theta, 1 + 0 * theta
        rows = [c, -s, zero, zero], [s, c, zero, zero], [zero, zero, one, link.d + zero]
        turn = np.stack([np.stack(row, -1) for row in (*rows, [zero, zero, zero, one])], -2)
        ca, sa = np.cos(float(link.alpha)), np.sin(float(link.alpha))
        twist = np.array([[1, 0, 0, link.a], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
        T = T @ (turn @ twist if robot.convention is Convention.STANDARD else twist @ turn)
    return T


def whole_turns(robot: Robot, difference: np.ndarray) -> np.ndarray:
    """Distance of joint-variable differences from a multiple of 2 pi."""
    q = difference @ robot.coupling.T
    return np.abs(q - 2 * np.pi * np.round(q / (2 * np.pi)))


def deviation(robot: Robot, T: np.ndarray, found) -> float:
    """Greatest deviation of the poses of all branches of targets (N, 4, 4)."""
    k, _ = np.nonzero(found.exists)
    return float(np.abs(poses(robot, found.phi[found.exists]) - T[k]).max())


def replaced(phi: np.ndarray, index: int, value: float) -> np.ndarray:
    phi = phi.copy()
    phi[index] = value
    return phi


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_every_branch_has_the_pose_and_one_is_where_it_came_from(robot):
    phi = np.random.default_rng(3).uniform(-3, 3, (500, 6))
    T = poses(robot, phi)
    found = inverse_branches(robot, T)
    assert deviation(robot, T, found) < 1e-12
    error = np.where(found.exists, whole_turns(robot, found.phi - phi[:, None]).max(-1), np.inf)
    assert error.min(axis=-1).max() < 1e-7  # a stretched elbow turns 1e-16 m into 1e-8 rad
    assert np.isnan(found.phi[~found.exists]).all()


@settings(max_examples=200, deadline=None)
@given(q=st.tuples(*[st.sampled_from([0.0, HALF, -HALF, np.pi]) | st.floats(-3.2, 3.2)] * 6))
def test_branches_hold_at_singular_configurations_too(q):
    """Right angles stretch the elbow, align the wrist and put the wrist centre over the base."""
    T = poses(UR10, np.array(q))[None]
    assert deviation(UR10, T, inverse_branches(UR10, T, reference=q)) < RESIDUAL


@pytest.mark.parametrize("small", [1e-15, 1e-12, 1e-11, 3e-11, 1e-10, 1e-9, 1e-7, 1e-4])
@pytest.mark.parametrize("joint", [2, 4])
def test_branches_hold_near_singularities(small, joint):
    phi = GENERIC.copy()
    phi[joint] = small
    T = poses(UR5E, phi)[None]
    found = inverse_branches(UR5E, T, reference=phi)
    assert found.exists.sum() >= 4
    assert deviation(UR5E, T, found) < RESIDUAL


@pytest.mark.parametrize("wrist", [1e-12, 3e-11, 1e-10, 1e-9, 6e-8, 1e-6, 1e-4])
@pytest.mark.parametrize("elbow", [0.0, 1e-9, 1e-7])
def test_a_stretched_arm_with_a_nearly_aligned_wrist_is_in_reach(elbow, wrist):
    """A rounding of 1e-16 divided by the sine of the wrist turns axis 4 out of the reach."""
    phi = np.random.default_rng(7).uniform(-3, 3, (50, 6))
    phi[:, 2], phi[:, 4] = elbow, wrist
    T = poses(UR10, phi)
    found = inverse_branches(UR10, T, reference=phi[0])
    assert found.exists.any(axis=-1).all()
    assert deviation(UR10, T, found) < RESIDUAL


@pytest.mark.parametrize("robot", [UR10, UR5E, UR3E], ids=lambda robot: robot.name)
def test_a_generic_pose_has_eight_different_branches(robot):
    found = inverse_branches(robot, poses(robot, GENERIC))
    assert found.exists.all()
    assert not found.singular.any()
    q = found.phi
    apart = [whole_turns(robot, q[i] - q[j]).max() for i in range(8) for j in range(i)]
    assert min(apart) > 0.1


def test_a_search_from_many_starts_finds_no_other_solution():
    T = poses(UR10, GENERIC)
    found, hits = inverse_branches(UR10, T), set()
    for start in np.random.default_rng(5).uniform(-np.pi, np.pi, (60, 6)):
        try:
            phi = inverse_numeric(UR10, T, start, restarts=0)
        except NotConvergedError:
            continue
        error = whole_turns(UR10, found.phi - phi).max(-1)
        assert np.nanmin(error) < 1e-6
        hits.add(int(np.nanargmin(error)))
    assert len(hits) == 8


def test_free_angle_of_an_aligned_wrist_keeps_its_reference():
    phi = replaced(GENERIC, 4, 0.0)
    T = poses(UR10, phi)
    found = inverse_branches(UR10, T, reference=phi)
    nearest = int(np.nanargmin(np.abs(found.phi - phi).max(-1)))
    assert found.singular[nearest] == Singularity.WRIST
    np.testing.assert_allclose(found.phi[nearest], phi, rtol=0, atol=1e-9)
    other = inverse_branches(UR10, T, reference=phi + 0.3)
    aligned = other.exists & ((other.singular & Singularity.WRIST) > 0)
    np.testing.assert_allclose(other.phi[aligned, 5], phi[5] + 0.3, rtol=0, atol=1e-12)


def test_free_angle_moves_to_the_reach_where_its_reference_is_outside():
    """The arm is nearly stretched; with theta6 half a turn on, axis 4 would be 0.2 m further."""
    phi = np.array([0.3, -0.4, 0.02, -HALF, 0.0, 0.5])
    T = poses(UR10, phi)
    found = inverse_branches(UR10, T[None], reference=replaced(phi, 5, 0.5 + np.pi))
    assert deviation(UR10, T[None], found) < RESIDUAL
    aligned = found.exists[0] & ((found.singular[0] & Singularity.WRIST) > 0)
    assert (found.singular[0, aligned] & Singularity.ELBOW).all()
    assert aligned.any()


def test_free_angle_of_the_shoulder_keeps_its_reference():
    """Without an offset along axis 2 the wrist centre can be on axis 1."""
    links = list(UR10.links)
    links[3] = replace(links[3], d=0)
    robot = Robot(links, name="no shoulder offset")
    T = poses(robot, GENERIC)
    T[:2, 3] = 0.0922 * T[:2, 2]  # the wrist centre is d6 behind the tool
    found = inverse_branches(robot, T[None], reference=np.full(6, 0.7))
    assert (found.singular[found.exists] & Singularity.SHOULDER).all()
    np.testing.assert_allclose(found.phi[found.exists][:, 0], 0.7, rtol=0, atol=1e-12)
    assert deviation(robot, T[None], found) < RESIDUAL


def test_a_singular_shoulder_and_a_stretched_elbow_are_reported():
    d4 = 0.163941
    T = np.eye(4)
    T[:3, :3] = poses(UR10, GENERIC)[:3, :3]
    T[:3, 3] = np.array([0.0, d4, 0.5]) + 0.0922 * T[:3, 2]  # as near to axis 1 as d4 allows
    found = inverse_branches(UR10, T)
    assert (found.singular[found.exists] & Singularity.SHOULDER).all()
    J = compile(UR10).jacobian(found.phi[found.exists])
    assert np.linalg.svd(J, compute_uv=False)[:, -1].max() < 1e-7
    stretched = inverse_branches(UR10, poses(UR10, replaced(GENERIC, 2, 0.0)))
    assert (stretched.singular[stretched.exists] & Singularity.ELBOW).any()


@pytest.mark.parametrize("beyond", [1e-6, 0.1, 3.0])
def test_an_unreachable_target_says_by_how_much(beyond):
    """Stretched upwards with its wrist in line: all solutions have axis 4 that far too high."""
    phi = np.array([0.3, -HALF, 0.0, 0.0, HALF, 0.0])
    T = compile(UR10).pose(phi)
    T[2, 3] += beyond
    with pytest.raises(UnreachableError, match="mm outside the workspace") as caught:
        inverse_branches(UR10, np.stack([compile(UR10).pose(GENERIC), T]))
    assert caught.value.index == 1
    assert caught.value.distance == pytest.approx(beyond, rel=1e-6)


def test_a_path_follows_one_branch_within_its_limits():
    phi = GENERIC + np.linspace(0, 1, 400)[:, None] * [4.0, 0.3, -0.4, 0.5, -2.0, 5.0]
    T = compile(UR10).pose(phi)  # joint 1 passes pi, joint 5 its singularity
    path = inverse_path(UR10, T, start=phi[0], limits=UR10_LIMITS)
    np.testing.assert_allclose(path, phi, rtol=0, atol=1e-9)
    narrow = Limits(lower=(-3.0,) * 6, upper=(3.0,) * 6, speed=(1.0,) * 6)
    with pytest.raises(ValueError, match=r"target \d+ of 400 leaves the joint limits"):
        inverse_path(UR10, T, phi[0], narrow)


@pytest.mark.parametrize(
    ("index", "parameters", "complaint"),
    [
        (4, {"a": 0.02}, "axes 5 and 6 do not meet: a5 = 0.02 m"),
        (3, {"alpha": 1.0}, "the wrist axes are not at right angles: alpha4"),
        (0, {"alpha": 0.0}, "axes 1 and 2 are parallel"),
        (2, {"a": 0.0}, "upper arm or forearm has no length"),
        (2, {"alpha": 1e-4}, "the wrist is not spherical"),
    ],
)
def test_arms_of_another_kind_are_refused_with_the_fallback(index, parameters, complaint):
    links = list(UR10.links)
    links[index] = replace(links[index], **parameters)
    with pytest.raises(UnsolvableGeometryError, match=complaint) as caught:
        inverse_branches(Robot(links), np.eye(4))
    assert "inverse_numeric" in str(caught.value)


def test_branches_take_at_most_half_as_long_again_as_those_of_a_spherical_wrist():
    """The least of ten times each, in turns: a busy machine only adds to a time."""
    phi = np.random.default_rng(0).uniform(-2, 2, (1000, 6))
    targets = {robot: compile(robot).pose(phi) for robot in (UR10, LARGE_ROBOT)}
    least = dict.fromkeys(targets, np.inf)
    for _ in range(10):
        for robot, T in targets.items():
            start = time.process_time()
            inverse_branches(robot, T)
            least[robot] = min(least[robot], time.process_time() - start)
    assert least[UR10] <= 1.5 * least[LARGE_ROBOT]
