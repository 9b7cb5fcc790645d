"""Springs across the axes of arms with one axis to nine, and the parameters they make."""

from dataclasses import replace

import numpy as np
import pytest

from armside.assets import IRB1400_XML, LARGE_ROBOT_XML
from armside.sim.estimation.elasticity import (
    Elasticity,
    SpringPrior,
    names,
    nominal_elasticity,
    parameters_at,
)
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.structure import with_structure
from armside.sim.laser import Cut, prepare
from armside.sim.robot.model import load_model

PARENT = LARGE_ROBOT_XML.parent


def arm_of(robot):
    return nominal_arm(with_structure(robot), NominalCfg(structure=True))


FREE = {"two_link": 2, "scara": 4, "large": 6 + 6, "irb1400": 6 + 6, "panda_like": 7 + 6}
"""Degrees of freedom; both axes of the first are parallel."""


@pytest.mark.parametrize(("file", "free"), FREE.items())
def test_two_springs_stand_across_each_of_the_first_three_axes_of_an_arm_in_space(file, free):
    robot = file if file in ("large", "irb1400") else str(PARENT / f"{file}.toml")
    nominal = prepare(Cut(robot=robot)).nominal
    arm = arm_of(nominal)
    assert arm.n_free == free
    springs = nominal_elasticity(nominal, arm)
    across = np.setdiff1d(np.arange(free), arm.axes)
    gears = set(springs.stiffness[arm.axes].tolist())
    assert set(springs.stiffness[across].tolist()) <= gears


@pytest.mark.parametrize("file", [LARGE_ROBOT_XML, IRB1400_XML])
def test_springs_that_a_file_knows_are_not_assumed(file):
    mj = with_structure(load_model(file)).mj
    known = [mj.joint(i).name for i in range(mj.njnt)]
    assert not [name for name in known if name.startswith("struct_")]


@pytest.fixture(scope="module")
def springs():
    robot = load_model(LARGE_ROBOT_XML)
    return nominal_elasticity(robot, arm_of(robot))


def test_parameters_are_named_and_make_springs(springs):
    prior, known = SpringPrior(), names(springs)
    assert known[:2] == ("stiffness 1", "stiffness 1 across 1")
    assert known[2:4] == ("stiffness 1 across 2", "stiffness 2")
    assert known[12:15] == ("damping", "damping of the structure", "lost motion")
    assert len(known) == len(prior.standard_deviation(springs)) == 20
    theta = np.zeros(20)
    theta[[0, 1, 12, 15]] = 0.5, -0.3, 0.2, 0.004
    found = parameters_at(springs, theta)
    ratio = found.springs.stiffness / springs.stiffness
    assert ratio == pytest.approx(np.exp([0.5, -0.3, *[0.0] * 10]))
    damped = found.springs.damping / springs.damping
    assert damped[springs.axes] == pytest.approx(np.exp(0.2))
    assert (found.clock_offset, found.process_noise) == (0.004, 0.05)
    theta[14] = -1.5  # a width below zero is none
    assert not parameters_at(springs, theta).springs.lost_motion.any()


def test_a_rigid_structure_leaves_the_gears_alone(springs):
    rigid = springs.on_rigid_structure
    across = np.setdiff1d(np.arange(12), springs.axes)
    assert np.array_equal(rigid.stiffness[springs.axes], springs.stiffness[springs.axes])
    assert rigid.stiffness[across] == pytest.approx(1e3 * springs.stiffness[across])


def test_a_prior_says_what_is_out_of_range():
    with pytest.raises(ValueError, match="clock must be > 0"):
        SpringPrior(clock=0.0)


SPRINGS = Elasticity(
    stiffness=np.array([1000.0, 400.0]),
    damping=np.array([2.0, 3.0]),
    axes=np.array([0]),
    softening=np.array([0.5, 0.0]),
    lost_motion=np.array([0.1, 0.0]),
)


def test_a_gear_is_as_much_softer_as_it_spends_time_within_its_lost_motion():
    """Half of its stiffness is missing there: a quarter of the time takes an eighth."""
    angle = np.array([[0.05, 1.0], [-0.2, 1.0], [0.2, 1.0], [0.1, 1.0]])
    np.testing.assert_allclose(SPRINGS.mean_slope(angle).stiffness, [875.0, 400.0])
    np.testing.assert_allclose(SPRINGS.mean_slope(0.0 * angle).stiffness, [500.0, 400.0])


def test_factors_of_damping_tell_gears_from_the_structure():
    scaled = SPRINGS.scaled(np.array([2.0, 3.0]), 5.0, 7.0, 2.0)
    np.testing.assert_allclose(scaled.stiffness, [2000.0, 1200.0])
    np.testing.assert_allclose(scaled.damping, [10.0, 21.0])
    np.testing.assert_allclose(scaled.lost_motion, [0.2, 0.0])


def test_parameters_of_arrays_are_told_apart_as_objects():
    """So that a set-up that holds them can be compared and be a key."""
    known = parameters_at(SPRINGS, np.zeros(7))
    assert {known: "known"}[known] == "known"
    assert known != replace(known)
