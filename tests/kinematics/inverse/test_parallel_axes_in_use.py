"""Arms whose axes 2, 3 and 4 are parallel: reach, limits, paths, refusals and time."""

import time
from dataclasses import replace

import numpy as np
import pytest

from armside.kinematics import (
    LARGE_ROBOT,
    UR10,
    UR10_LIMITS,
    Limits,
    Robot,
    UnreachableError,
    UnsolvableGeometryError,
    compile,
    inverse_branches,
    inverse_nearest,
    inverse_path,
)

HALF = np.pi / 2
GENERIC = np.array([0.3, -1.2, 0.9, 0.4, 1.1, -0.6])


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


def test_the_nearest_solution_takes_whole_turns_to_be_within_the_limits():
    phi = np.array([-5.0, -1.2, 0.9, 5.0, 1.1, 6.0])
    T = compile(UR10).pose(phi)
    np.testing.assert_allclose(inverse_nearest(UR10, T, phi, UR10_LIMITS), phi, rtol=0, atol=1e-9)
    within = Limits(lower=(-3.2,) * 6, upper=(3.2,) * 6, speed=(1.0,) * 6)
    assert within.contain(inverse_nearest(UR10, T, phi, within))


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
