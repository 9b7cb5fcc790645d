"""Path accuracy and repeatability, against cases worked out by hand."""

import numpy as np
import pytest

from armside.ilc.measures.iso9283 import crossings, path_accuracy, path_repeatability

SQUARE = np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
"""Corners of an attained path around the origin, counter-clockwise."""


def test_a_crossing_is_interpolated_between_samples():
    commanded, tangent = np.array([[0.9, 0.25]]), np.array([[0.0, 1.0]])
    np.testing.assert_allclose(crossings(commanded, tangent, SQUARE), [[1.0, 0.25]])


def test_the_last_sample_is_joined_to_the_first():
    commanded, tangent = np.array([[0.25, -0.8]]), np.array([[1.0, 0.0]])
    np.testing.assert_allclose(crossings(commanded, tangent, SQUARE), [[0.25, -1.0]])


def test_of_two_crossings_the_nearest_counts_and_one_in_the_opposite_direction_does_not():
    path = np.array([[0.0, 5.0], [1.0, 5.0], [1.0, 4.0], [0.0, 4.0], [0.0, 1.0], [1.0, 1.0]])
    commanded, tangent = np.array([[0.5, 3.5]]), np.array([[1.0, 0.0]])
    # At x = 0.5 it comes by at y = 5 and 1 along the tangent, and at y = 4 against it.
    np.testing.assert_allclose(crossings(commanded, tangent, path), [[0.5, 5.0]])


def test_a_plane_that_is_never_crossed_has_no_position():
    assert np.isnan(crossings(np.array([[9.0, 0.0]]), np.array([[1.0, 0.0]]), SQUARE)).all()


def test_accuracy_is_the_largest_distance_of_a_barycentre():
    commanded = np.zeros((2, 3))
    runs = np.zeros((2, 2, 3))
    runs[:, 0, 0] = [5.0, -5.0]  # their barycentre is on the command
    runs[0, 1], runs[1, 1] = [3.0, 4.0, 1.0], [3.0, 4.0, -1.0]  # theirs is (3, 4, 0)
    assert path_accuracy(commanded, runs) == pytest.approx(5.0)


def test_repeatability_is_mean_and_three_deviations_of_the_distance_from_the_barycentre():
    # Barycentre 1, distances 1, 1, 2: mean 4/3, standard deviation sqrt(1/3).
    runs = np.array([0.0, 0.0, 3.0]).reshape(3, 1, 1)
    assert path_repeatability(runs) == pytest.approx(4 / 3 + 3 * np.sqrt(1 / 3))


def test_repeatability_is_that_of_the_worst_point_and_ignores_a_common_error():
    runs = np.zeros((2, 3, 2))
    runs[0, 1], runs[1, 1] = [1.0, 1.0], [1.0, -1.0]
    assert path_repeatability(runs) == pytest.approx(1.0)
    assert path_repeatability(runs + 7.0) == pytest.approx(1.0)


def test_missing_positions_leave_no_measure():
    runs = np.zeros((2, 3, 2))
    runs[0, 1] = np.nan
    assert np.isnan(path_accuracy(np.zeros((3, 2)), runs))
    assert np.isnan(path_repeatability(runs))


def test_bad_runs_are_named():
    with pytest.raises(ValueError, match="two runs or more, got 1"):
        path_repeatability(np.zeros((1, 3, 2)))
    with pytest.raises(ValueError, match="shape"):
        path_accuracy(np.zeros((3, 2)), np.zeros((3, 2)))
