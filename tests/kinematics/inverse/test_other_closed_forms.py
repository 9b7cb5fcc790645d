"""Closed forms of SCARAs, of the Stanford arm and of S-R-S arms by their elbow angle."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from tests.benchmarks._arms import PANDA, PUMA_560, STANFORD_ARM

from armside.kinematics import (
    LARGE_ROBOT,
    Joint,
    Link,
    Robot,
    Singularity,
    UnreachableError,
    UnsolvableGeometryError,
    elbow_angle,
    inverse_branches,
    scara_branches,
    seven_axis_branches,
    stanford_branches,
)
from armside.kinematics.rigid import link_frames

EXACT = 1e-10
SLIDE = Joint.PRISMATIC
MOUNT = Link(0.3, 0.2, 0.1, 0.4, joint=Joint.FIXED)
TOOL = Link(-0.2, 0.1, 0.05, 0.7, joint=Joint.FIXED)
COUPLED = np.eye(4) + 0.3 * np.diag([1, 0, 1], -1)
SCARA = Robot(
    [MOUNT, Link(d=0.4, a=0.325), Link(a=0.275, alpha=pi), Link(joint=SLIDE), Link(d=0.1), TOOL],
    coupling=COUPLED,
    offset=[0.1, -0.4, 0.05, 0.2],
    name="SCARA",
)
SLIDE_FIRST = Robot(
    [Link(joint=SLIDE), Link(a=0.3), Link(a=0.4, alpha=pi), Link(d=0.1)], name="slide first"
)
OFFSET_STANFORD = Robot(
    [MOUNT, *(replace(STANFORD_ARM.links[0], a=0.07), *STANFORD_ARM.links[1:]), TOOL],
    offset=[0.1, -0.2, 0.6, 0.3, 0.2, -0.1],
    name="Stanford arm with an offset",
)
# KUKA LBR iiwa 14 R820, lengths of its data sheet.
LBR = Robot(
    [
        MOUNT,
        Link(d=0.36, alpha=-pi / 2),
        Link(alpha=pi / 2),
        Link(d=0.42, alpha=pi / 2),
        Link(alpha=-pi / 2),
        Link(d=0.40, alpha=-pi / 2),
        Link(alpha=pi / 2),
        Link(d=0.126),
        TOOL,
    ],
    name="LBR iiwa 14",
)
BENT = Robot(
    [
        replace(link, a=0.03 if i == 3 else -0.05 if i == 4 else 0)
        for i, link in enumerate(LBR.links)
    ],
    offset=[0.1, 0.2, -0.1, 0.4, 0.3, 0.1, 0.2],
    name="LBR with an offset elbow",
)


def pose(robot: Robot, phi: np.ndarray) -> np.ndarray:
    return np.array([link_frames(robot, each)[-1] for each in phi])


def drawn(robot: Robot, count: int = 40) -> np.ndarray:
    phi = np.random.default_rng(0).uniform(-1.5, 1.5, (count, robot.n_joints))
    return phi


def check(robot: Robot, found, phi: np.ndarray, T: np.ndarray) -> None:
    """Each branch has the target, one of them is the original, and all are different."""
    for k in range(len(phi)):
        own = found.phi[k][found.exists[k]]
        np.testing.assert_allclose(pose(robot, own), T[[k] * len(own)], rtol=0, atol=EXACT)
        gap = (own - phi[k]) @ robot.coupling.T
        turning = [robot.links[i].joint is Joint.REVOLUTE for i in robot.moving]
        gap -= np.where(turning, 2 * pi * np.round(gap / (2 * pi)), 0)
        assert np.abs(gap).max(axis=1).min() < 1e-8
        apart = np.abs(own[:, None] - own[None]).max(axis=-1) + np.eye(len(own))
        assert apart.min() > 1e-6


@pytest.mark.parametrize("robot", [SCARA, SLIDE_FIRST], ids=lambda r: r.name)
def test_both_branches_of_a_scara(robot):
    phi = drawn(robot)
    T = pose(robot, phi)
    found = scara_branches(robot, T)
    assert found.phi.shape == (40, 2, 4)
    assert found.exists.all()
    check(robot, found, phi, T)
    alone = scara_branches(robot, T[3]).phi  # sums of another length, in another order
    np.testing.assert_allclose(alone, found.phi[3], rtol=0, atol=1e-14)


def test_all_branches_of_an_elbow_arm_with_a2_below_zero():
    links = [replace(x, a=-1.075) if i == 1 else x for i, x in enumerate(LARGE_ROBOT.links)]
    robot = Robot(links, offset=LARGE_ROBOT.offset)
    phi = drawn(robot)
    T = pose(robot, phi)
    found = inverse_branches(robot, T)
    assert found.exists.sum(axis=1).max() == 8
    check(robot, found, phi, T)


def test_a_scara_says_reach_tilt_and_stretch():
    T = pose(SLIDE_FIRST, np.array([[0.1, 0.3, 0.0, 0.2]]))
    assert (scara_branches(SLIDE_FIRST, T).singular == Singularity.ELBOW).all()
    T[0, :2, 3] *= 1.5
    with pytest.raises(UnreachableError, match=r"target 0 .* 350\.000 mm outside"):
        scara_branches(SLIDE_FIRST, T)
    T[0, :3, :3] = T[0, :3, :3] @ [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    with pytest.raises(ValueError, match="target 0 is tilted by 90 deg"):
        scara_branches(SLIDE_FIRST, T)


@pytest.mark.parametrize("robot", [STANFORD_ARM, OFFSET_STANFORD], ids=lambda r: r.name)
def test_all_branches_of_the_stanford_arm(robot):
    phi = drawn(robot)
    T = pose(robot, phi)
    found = stanford_branches(robot, T)
    assert found.exists.sum(axis=1).max() == 8
    check(robot, found, phi, T)


def test_the_stanford_arm_says_reach_and_wrist():
    phi = np.array([[0.2, 0.5, 0.6, 0.4, 0.0, 0.1]])
    T = pose(STANFORD_ARM, phi)
    found = stanford_branches(STANFORD_ARM, T)
    assert (found.singular & Singularity.WRIST).any()
    np.testing.assert_allclose(pose(STANFORD_ARM, found.phi[0, :1]), T, rtol=0, atol=EXACT)
    T[0, :3, 3] = T[0, :3, 2] * 0.263 + [0.1, 0, 0.412]
    with pytest.raises(UnreachableError, match=r"54\.000 mm outside"):
        stanford_branches(STANFORD_ARM, T)


@pytest.mark.parametrize("robot", [LBR, BENT], ids=lambda r: r.name)
def test_all_branches_of_seven_axes_have_the_stated_elbow_angle(robot):
    phi = drawn(robot)
    T, elbow = pose(robot, phi), np.array([elbow_angle(robot, each) for each in phi])
    found = seven_axis_branches(robot, T, elbow)
    assert found.phi.shape == (40, 8, 7)
    check(robot, found, phi, T)
    for k in range(5):
        for own in found.phi[k]:
            off = elbow_angle(robot, own) - elbow[k]
            assert abs(np.angle(np.exp(1j * off))) < 1e-8
    other = seven_axis_branches(robot, T, 0.4)
    np.testing.assert_allclose(pose(robot, other.phi[:, 5]), T, rtol=0, atol=EXACT)
    assert elbow_angle(robot, other.phi[7, 5]) == pytest.approx(0.4)


def test_a_straight_arm_and_one_out_of_reach_are_said():
    phi = np.array([[0.3, 0.4, 0.2, 0.0, 0.5, 0.6, 0.7]])
    T = pose(LBR, phi)
    assert (seven_axis_branches(LBR, T, 0.0).singular & Singularity.ELBOW).all()
    T[0, :3, 3] += [0, 0, 2.0]
    with pytest.raises(UnreachableError, match="mm outside the workspace"):
        seven_axis_branches(LBR, T, 0.0)


@pytest.mark.parametrize("bend", [np.pi, np.pi - 1e-9, np.pi - 1e-6])
def test_a_folded_arm_of_equal_lengths_has_its_wrist_in_its_shoulder(bend):
    equal = (replace(link, d=0.4) if link.d == 0.42 else link for link in LBR.links)
    robot = Robot(list(equal), name="equal lengths")
    phi = np.array([[0.2, 0.9, 0.1, bend, 0.3, 0.4, 0.5], [1.2, -0.4, 0.7, -bend, 0.2, 0.9, 0.1]])
    T = pose(robot, phi)
    found = seven_axis_branches(robot, T, [elbow_angle(robot, each) for each in phi])
    for branch in range(8):
        reached = pose(robot, found.phi[:, branch])
        np.testing.assert_allclose(reached, T, rtol=0, atol=2 * EXACT)
    assert bool((found.singular & Singularity.ELBOW).all()) == (bend > np.pi - 1e-7)
    with pytest.raises(ValueError, match=r"elbow must be one angle or \(2,\)"):
        seven_axis_branches(robot, T, [0.0, 0.1, 0.2])


@pytest.mark.parametrize(
    ("solve", "robot", "complaint"),
    [
        (scara_branches, PUMA_560, "a SCARA has 4 and 1"),
        (scara_branches, Robot([*SLIDE_FIRST.links[:3], Link(alpha=0.1), TOOL]), ""),
        (stanford_branches, PUMA_560, "its joints are RRRRRR, not RRPRRR"),
        (lambda r, T: seven_axis_branches(r, T, 0.0), PANDA, "do not meet"),
        (lambda r, T: seven_axis_branches(r, T, 0.0), PUMA_560, "not RRRRRRR"),
    ],
)
def test_arms_of_another_kind_are_refused_with_the_reason(solve, robot, complaint):
    if not complaint:  # a twist after the last axis is the tool's
        assert solve(robot, pose(robot, drawn(robot, 1))).exists.all()
        return
    with pytest.raises(UnsolvableGeometryError, match=complaint):
        solve(robot, np.eye(4))


def test_no_targets_have_no_solutions_and_a_scara_has_two_lengths():
    none = np.empty((0, 4, 4))
    assert scara_branches(SCARA, none).phi.shape == (0, 2, 4)
    assert stanford_branches(STANFORD_ARM, none).phi.shape == (0, 8, 6)
    assert seven_axis_branches(LBR, none, 0.0).phi.shape == (0, 8, 7)
    for lengths in ((0.3, 0.0), (0.0, 0.3)):
        links = [Link(a=a) for a in lengths]
        with pytest.raises(UnsolvableGeometryError, match="has no length"):
            scara_branches(Robot([*links, Link(joint=SLIDE), Link()]), np.eye(4))


def test_axes_that_are_nearly_square_or_parallel_are_refused():
    tilted = Robot([Link(a=0.3, alpha=1e-3), *SLIDE_FIRST.links[2:], Link(joint=SLIDE)])
    with pytest.raises(UnsolvableGeometryError, match="axes are not parallel"):
        scara_branches(tilted, np.eye(4))
    links = [replace(STANFORD_ARM.links[0], alpha=-1.5), *STANFORD_ARM.links[1:]]
    with pytest.raises(UnsolvableGeometryError, match="axes 1 and 2 are not at right angles"):
        stanford_branches(Robot(links), np.eye(4))
