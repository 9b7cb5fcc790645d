"""Figures that an identification is scored by."""

import numpy as np
import pytest

from armside import assets
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, prepare
from armside.sim.laser.identification import assigned, directions, identified, unidentified
from armside.sim.laser.tool_measure import ToolPath


def test_a_mode_counts_as_identified_within_a_tenth_and_once():
    true, found = np.array([7.2, 7.3, 11.9, 14.9]), np.array([7.2, 7.7, 14.7, 40.3, 55.0, 60.0])
    assert assigned(true, found) == [7.2, 7.7, None, 14.7]
    assert assigned(np.array([7.0, 7.1]), np.array([7.05])) in ([7.05, None], [None, 7.05])
    assert assigned(np.array([10.0]), np.array([11.1])) == [None]


def test_the_springs_of_an_arm_in_a_plane_are_identified_and_scored_in_it():
    robot = str(assets.LARGE_ROBOT_XML.with_name("two_link.toml"))
    experiment = prepare(Cut(robot=robot, imu=ImuCfg()), seed=1)
    found = identified(experiment, ToolPath().assumed(experiment))
    assumed, springs = (
        np.abs(np.log(found["truth"][f"{name}_over_true"])) for name in ("assumed", "identified")
    )
    assert springs.max() < 0.05
    assert springs.max() < assumed.max()
    assert found["consistency"]["nees_expected"] == 2.0
    assert found["consistency"]["nees_of_filter"] > 2.0 * found["consistency"]["nees"]
    assert 0.5 < found["consistency"]["nees"] < 4.0
    sd, error = (found["consistency"][f"tool_{name}"] for name in ("standard_deviation", "error"))
    assert 0.5 < error / sd < 2.0


def test_parameters_that_keep_their_prior_are_named():
    names = ("stiffness 1", "mounting x", "clock")
    assert unidentified(names, np.array([0.99, 0.2, 0.5])) == ["mounting x"]


def test_a_tool_is_scored_in_the_directions_in_which_it_moves():
    plane = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    moving = directions(plane)
    assert moving.shape == (3, 2)
    assert moving[2] == pytest.approx(np.zeros(2), abs=1e-12)
    assert np.array_equal(directions(np.eye(3)), np.eye(3))


@pytest.mark.parametrize(("part", "moving"), [(0.5, 2), (2.0, 3)])
def test_a_direction_is_immovable_below_a_billionth_of_the_one_that_moves_most(part, moving):
    assert directions(np.diag([2.0, 1.0, 2.0 * part * 1e-9])).shape == (3, moving)
