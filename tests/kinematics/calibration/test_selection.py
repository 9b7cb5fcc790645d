"""Ranks of the textbook, redundant parameters by name, poses that tell most."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from tests.benchmarks._arms import PUMA_560

from armside.kinematics import CATALOGUE, Joint, Link, Robot, compile
from armside.kinematics.calibration import (
    Choice,
    ErrorModel,
    Measurements,
    Priors,
    fit,
    identifiable,
    next_poses,
)
from armside.kinematics.calibration.fit import jacobian_of_points

SCARA = Robot(
    [
        Link(d=0.3, a=0.4),
        Link(a=0.25, alpha=pi),
        Link(joint=Joint.PRISMATIC),
        Link(d=0.1),
    ],
    name="SCARA",
)
ROBOTS = {"Puma": PUMA_560, "UR10": CATALOGUE["ur10"].robot, "IRB120": CATALOGUE["irb120"].robot}
OFFSETS = np.array([[0.05, 0.02, 0.1], [-0.06, 0.03, 0.08], [0.01, -0.08, 0.12]])


def seen(robot, n=60, targets=1, rotation=False, seed=0):
    phi = np.random.default_rng(seed).uniform(-3.0, 3.0, (n, robot.n_joints))
    T = compile(robot).pose(phi)
    points = T[:, None, :3, 3] + np.einsum("nij,tj->nti", T[:, :3, :3], OFFSETS[:targets])
    return Measurements(phi=phi, points=points, rotation=T[:, :3, :3] if rotation else None)


@pytest.mark.parametrize("name", ROBOTS)
def test_rank_is_the_number_of_the_textbook(name):
    """4 R + 2 P + 6 with base and tool, R = 6; a point lacks 3 of orientation; a point more has 3.

    Everett, Driels, Mooring, Kinematic modelling for robot calibration, 1987.
    """
    model = ErrorModel(ROBOTS[name])
    for data, expected in (
        (seen(ROBOTS[name]), 27),
        (seen(ROBOTS[name], targets=3), 33),
        (seen(ROBOTS[name], rotation=True), 30),
    ):
        found = identifiable(model, data)
        assert found.all.rank == found.chosen.rank == expected
        assert found.chosen.smallest > 1e-3
        # What is left of the redundant parameters is rounding.
        assert (found.all.values[expected:] < 1e-12).all()


def test_rank_of_an_arm_with_a_prismatic_joint():
    """4 R + 2 P + 6 = 20 for poses; a point lacks 3."""
    rank = identifiable(ErrorModel(SCARA), seen(SCARA)).all.rank
    assert rank == 4 * 3 + 2 * 1 + 6 - 3


def test_hayatis_parameter_replaces_the_offset_where_axes_are_parallel():
    found = identifiable(ErrorModel(ROBOTS["UR10"]), seen(ROBOTS["UR10"]))
    assert {"beta_2", "beta_3", "d_2"} <= set(found.geometry)
    assert not {"d_3", "d_4", "beta_1", "beta_4", "beta_5"} & set(found.geometry)
    same = {dependence.name: dependence.same_as for dependence in found.redundant}
    assert same["d_3"] == same["d_4"] == ("d_2",)
    assert same["theta_1"] == ("base_rz",)


def test_a_redundant_set_is_named_and_not_fitted():
    model, data = ErrorModel(ROBOTS["UR10"]), seen(ROBOTS["UR10"])
    with pytest.raises(ValueError, match="d_3 cannot be told from d_2"):
        identifiable(model, data, ("a_2", "d_2", "d_3"))
    with pytest.raises(ValueError, match="Unknown parameter 'd_9'"):
        identifiable(model, data, ("d_9",))
    with pytest.raises(ValueError, match="base_x is always fitted"):
        identifiable(model, data, ("base_x",))
    assert set(identifiable(model, data, ("a_2", "d_3")).geometry) == {"a_2", "d_3"}


def test_the_worst_seen_combination_is_named():
    data = seen(PUMA_560, seed=1)
    phi = data.phi.copy()
    phi[:, 4] = 0.3 + 1e-3 * phi[:, 4]  # joint 5 hardly moves
    T = compile(PUMA_560).pose(phi)
    points = (T[:, :3, 3] + T[:, :3, :3] @ OFFSETS[0])[:, None]
    found = identifiable(ErrorModel(PUMA_560), replace(data, phi=phi, points=points))
    assert found.chosen.smallest < 1e-3
    assert any(
        name.endswith(("_4", "_5")) or name.startswith("target") for name in found.chosen.weakest
    )


def test_proposed_poses_tell_more_than_random_ones():
    robot, model = ROBOTS["IRB120"], ErrorModel(ROBOTS["IRB120"])
    limits = CATALOGUE["irb120"].limits
    data = seen(robot, n=15)
    names = identifiable(model, seen(robot)).geometry
    known = fit(model, data, Choice(names), Priors(noise=1e-4))
    rng = np.random.default_rng(0)

    def information(phi):
        J = jacobian_of_points(known, phi).reshape(-1, len(known.x)) / known.noise
        return np.linalg.slogdet(np.linalg.inv(known.covariance) + J.T @ J)[1]

    best = next_poses(known, limits, 8, np.random.default_rng(1))
    assert limits.contain(best).all()
    random = [information(rng.uniform(limits.lower, limits.upper, (8, 6))) for _ in range(30)]
    assert information(best) > max(random)
