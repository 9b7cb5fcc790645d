"""Path from rest, and the arm that is assumed wrong on purpose."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside import assets
from armside.sim.estimation.nominal import assumed_arm, nominal_arm
from armside.sim.estimation.relative_path import REST_SAMPLES, relative_to_start
from armside.sim.robot.model import load_model


def test_a_path_is_relative_to_the_mean_of_its_rest():
    rng = np.random.default_rng(0)
    assert REST_SAMPLES == 25
    position = np.concatenate([1.0 + 1e-3 * rng.standard_normal((25, 3)), np.full((5, 3), 2.0)])
    path = relative_to_start(position)
    assert path[:25, :3].mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-15)
    assert path[25:, :3] == pytest.approx(np.tile(2.0 - position[:25].mean(axis=0), (5, 1)))
    assert not path[:, 3:].any()


def test_a_rotation_from_rest_is_about_base_axes():
    """The tool first points anywhere, then turns about the base's z axis."""
    start = Rotation.from_euler("XYZ", [0.3, 1.2, -0.7])
    angles = np.concatenate([np.zeros(25), np.linspace(0.0, 0.2, 10)])
    turned = Rotation.from_rotvec(np.outer(angles, [0.0, 0.0, 1.0])) * start
    path = relative_to_start(np.zeros((35, 3)), turned.as_quat(scalar_first=True))
    assert path[:, 3:] == pytest.approx(np.outer(angles, [0.0, 0.0, 1.0]), abs=1e-12)


def test_the_assumed_stiffness_is_wrong_by_up_to_what_is_stated():
    robot = load_model(assets.LARGE_ROBOT_XML)
    right = nominal_arm(robot).stiffness
    factors = np.array([assumed_arm(robot, 0.3, s).stiffness / right for s in range(8)])
    assert np.abs(factors - 1.0).max() <= 0.3
    assert np.abs(factors - 1.0).max() > 0.27  # of 48 draws
    assert len(np.unique(factors)) == factors.size  # each axis and seed its own
    again = assumed_arm(robot, 0.3, 7).stiffness / right
    assert np.array_equal(again, factors[7])


def test_an_assumption_without_error_has_no_sign():
    robot = load_model(assets.LARGE_ROBOT_XML)
    plus, minus = (assumed_arm(robot, error, seed=0).stiffness for error in (0.0, -0.0))
    assert np.array_equal(plus, minus)
