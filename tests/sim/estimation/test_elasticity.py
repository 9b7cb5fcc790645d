"""Springs of an arm."""

from dataclasses import replace

import numpy as np

from armside.sim.estimation.elasticity import Elasticity, parameters_at

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
