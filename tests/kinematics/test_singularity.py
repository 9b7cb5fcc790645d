"""Singular configurations of any serial arm, by the rank of its Jacobian."""

import numpy as np
import pytest
from tests.benchmarks._arms import PANDA, PUMA_560, STANFORD_ARM

from armside.kinematics import IRB1400, Joint, Link, Robot, compile
from armside.kinematics.singularity import rank_loss, regular_rank

PLANAR = Robot([Link(a=0.5), Link(a=0.4), Link(a=0.3)])
SCARA = Robot([Link(a=0.3), Link(a=0.25, alpha=np.pi), Link(joint=Joint.PRISMATIC), Link()])
HALF = np.pi / 2


@pytest.mark.parametrize(
    ("robot", "rank"),
    [(IRB1400, 6), (PUMA_560, 6), (STANFORD_ARM, 6), (PANDA, 6), (PLANAR, 3), (SCARA, 4)],
)
def test_regular_rank_is_what_the_structure_can_do(robot, rank):
    assert regular_rank(robot) == rank


def test_an_aligned_wrist_loses_one_direction_of_rotation():
    phi = [0.3, 0.4, 0.2, 0.5, 0.0, -0.6]
    found = rank_loss(IRB1400, phi)
    assert found.is_singular
    assert (found.rank, found.regular_rank) == (5, 6)
    J = compile(IRB1400).jacobian(phi)
    np.testing.assert_allclose(found.lost.T @ J, 0, atol=1e-12)
    np.testing.assert_allclose(J @ found.idle, 0, atol=1e-12)
    np.testing.assert_allclose(
        np.abs(found.idle[:, 0]), np.sqrt([0, 0, 0, 0.5, 0, 0.5]), atol=1e-12
    )


@pytest.mark.parametrize(
    ("robot", "stretched", "bent", "ranks"),
    [
        (PLANAR, [0.3, 0.0, 0.0], [0.3, 0.4, 0.2], (2, 3)),
        (SCARA, [0.3, 0.0, 0.1, 0.2], [0.3, 0.4, 0.1, 0.2], (3, 4)),
    ],
    ids=["planar", "SCARA"],
)
def test_a_stretched_arm_loses_its_own_direction(robot, stretched, bent, ranks):
    """The planar arm keeps three motors, and of its directions the one across and the turn."""
    found = rank_loss(robot, stretched)
    assert (found.rank, found.regular_rank) == ranks
    along = [np.cos(0.3), np.sin(0.3), 0, 0, 0, 0]
    np.testing.assert_allclose(np.abs(found.lost.T @ along), [1.0], rtol=0, atol=1e-9)
    assert not rank_loss(robot, bent).is_singular


def test_a_redundant_arm_has_an_idle_motion_and_singularities_of_its_own():
    regular = rank_loss(PANDA, [0.1, 0.2, 0.3, -1.5, 0.4, 1.6, 0.5])
    assert not regular.is_singular
    assert regular.lost.shape == (6, 0)
    assert regular.idle.shape == (7, 1)
    stretched = rank_loss(PANDA, [0.0, 0.0, 0.0, 0.0, 0.0, HALF, 0.0])
    assert stretched.is_singular


@pytest.mark.parametrize("robot", [PLANAR, SCARA, IRB1400])
def test_the_least_singular_value_is_the_last_that_is_not_zero_elsewhere(robot):
    """By eigenvalues of J J^T, whose roots are known to 1e-8: where they do not vanish."""
    phi = np.linspace(0.3, 0.8, robot.n_joints)
    J = compile(robot).jacobian(phi)
    size = np.sqrt(np.sort(np.maximum(np.linalg.eigvalsh(J @ J.T), 0.0))[::-1])
    expected = size[regular_rank(robot) - 1]
    assert rank_loss(robot, phi).least_singular_value == pytest.approx(expected, rel=1e-6)


def test_what_idle_motors_regain_at_second_order_alone_is_not_listed():
    """By central differences of J v, beyond the range of J, for the idle rates v."""
    turns = [Link(alpha=HALF), Link(alpha=-HALF), Link(a=1.0)]
    robot = Robot([*turns, Link(alpha=HALF), Link(a=1.0, alpha=-HALF)])
    phi, h = HALF * np.array([-1.0, 2.0, 0.0, -1.0, -1.0]), 1e-6
    found, J = rank_loss(robot, phi), compile(robot).jacobian
    assert (found.rank, found.regular_rank) == (4, 5)
    beyond = np.eye(6) - J(phi) @ np.linalg.pinv(J(phi), rcond=1e-9)
    for step in h * np.eye(5):
        rate = (J(phi + step) - J(phi - step)) @ found.idle / (2.0 * h)
        np.testing.assert_allclose(beyond @ rate, 0.0, atol=1e-8)
    assert found.lost.shape == (6, 0)
