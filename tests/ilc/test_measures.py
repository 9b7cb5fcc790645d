"""Error measures: norms, circles, and those of ISO 9283."""

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from armside.ilc.measures.iso9283 import crossings, path_accuracy, path_repeatability
from armside.ilc.measures.norms import (
    circle_centre,
    circle_maxdev,
    circle_rms,
    fit_circle,
    inf_norm,
    normalise,
    repeatability,
    two_norm,
)


def circle_points(centre, normal, radius, n=400):
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    e1 = np.cross(normal, [0.3, -0.5, 0.8])
    e1 /= np.linalg.norm(e1)
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)[:, None]
    radius = np.broadcast_to(np.asarray(radius), n)[:, None]
    return centre + radius * (np.cos(angle) * e1 + np.sin(angle) * np.cross(normal, e1))


def test_the_norms_are_sums_and_maxima_over_the_record():
    error = np.array([[3.0, -1.0], [-4.0, 0.0]])
    assert two_norm(error).tolist() == [5.0, 1.0]
    assert inf_norm(error).tolist() == [4.0, 1.0]


def test_the_two_norm_survives_huge_and_zero_errors():
    assert two_norm(np.array([[1e300, 0.0], [1e300, 0.0]])) == pytest.approx([2**0.5 * 1e300, 0])


def test_normalising_divides_by_the_worst_motor_of_all_experiments_without_learning():
    measure = np.array([[2.0, 1.0], [0.5, 0.2]])  # (k, motor)
    all_k0 = np.array([[2.0, 1.0], [4.0, 0.1]])  # (experiment, motor)
    np.testing.assert_allclose(normalise(measure, all_k0), measure / 4.0)


def test_repeatability_is_the_largest_difference_over_the_best_error():
    first = np.array([[0.0, 1.0], [2.0, 1.0]])
    second = np.array([[0.5, 1.0], [2.0, 0.8]])
    np.testing.assert_allclose(repeatability(first, second, 0.25), [2.0, 0.8])
    with pytest.raises(ValueError, match="one shape"):
        repeatability(first, second[:1], 1.0)
    with pytest.raises(ValueError, match="best_error"):
        repeatability(first, second, 0.0)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), radius=st.floats(1e-3, 0.5))
def test_a_perfect_circle_has_no_error_wherever_it_lies(seed, radius):
    rng = np.random.default_rng(seed)
    centre, normal = rng.uniform(-2, 2, 3), rng.standard_normal(3)
    points = circle_points(centre, normal, radius)
    for plane in (None, normal):
        circle = fit_circle(points, plane)
        np.testing.assert_allclose(circle.centre, centre, atol=1e-9)
        assert circle.radius == pytest.approx(radius, abs=1e-9)
        assert circle_rms(circle.radii, radius) < 1e-9


def test_a_small_radius_is_an_error_although_the_fit_is_perfect():
    circle = fit_circle(circle_points([1.0, 0, 1.6], [0, 0, 1], 0.0048))
    assert circle_rms(circle.radii, 0.005) == pytest.approx(2e-4, rel=1e-6)
    assert circle_maxdev(circle.radii, 0.005) == pytest.approx(2e-4, rel=1e-6)


def test_an_oval_has_the_error_of_its_radius_deviation():
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    points = circle_points([0.0, 0, 0], [0, 0, 1], 5e-3 + 1e-4 * np.cos(2 * angle))
    circle = fit_circle(points, [0, 0, 1])
    assert circle_rms(circle.radii, 5e-3) == pytest.approx(1e-4 / 2**0.5, rel=1e-3)
    assert circle_maxdev(circle.radii, 5e-3) == pytest.approx(1e-4, rel=1e-3)


def test_deviation_out_of_a_given_plane_does_not_count():
    flat = circle_points([0.0, 0, 0], [0, 0, 1], 5e-3)
    lifted = flat + np.outer(1e-3 * np.sin(3 * np.linspace(0, 6, len(flat))), [0, 0, 1])
    assert circle_rms(fit_circle(lifted, [0, 0, 1]).radii, 5e-3) < 1e-9


def turn(centre, radius, span=2.0 * np.pi, n=60, first=0.3):
    angle = first + span * np.arange(n) / n
    return np.asarray(centre) + radius * np.column_stack((np.cos(angle), np.sin(angle)))


def residuals(centre, points):
    radii = np.hypot(*(points - centre).T)
    return radii - radii.mean()


def smallest(points):
    """Least sum of squares from starts all around, near and far."""
    mean = points.mean(axis=0)
    spread = np.sqrt(np.square(points - mean).sum(axis=1).mean())
    angles = np.arange(0.0, 2.0 * np.pi, np.pi / 3)
    starts = [
        mean + spread * far * np.array([np.cos(a), np.sin(a)])
        for far in (0.1, 1.0, 4.0)
        for a in angles
    ]
    return 2.0 * min(least_squares(residuals, s, args=(points,), method="lm").cost for s in starts)


@pytest.mark.parametrize("seed", range(40 if os.environ.get("ARMSIDE_CI") else 10))
def test_no_other_centre_fits_an_arc_better(seed):
    """Noise of 0.1 to 20 % of the radius, arcs from 20 degrees to whole turns."""
    rng = np.random.default_rng(seed)
    radius, span = 10.0 ** rng.uniform(-3, 0), np.deg2rad(rng.uniform(20.0, 360.0))
    points = turn(rng.uniform(-1, 1, 2), radius, span)
    points = points + radius * 10.0 ** rng.uniform(-3, -0.7) * rng.standard_normal(points.shape)
    found = np.square(residuals(circle_centre(points), points)).sum()
    assert found <= smallest(points) * (1.0 + 1e-6)


@pytest.mark.parametrize("n", [4, 60])
def test_a_point_on_the_centre_is_no_hole_in_the_fit(n):
    """The minimum is beside it: a point there has the largest residual."""
    points = np.vstack((turn((1.0, 2.0), 0.5, n=n), [1.0, 2.0]))
    centre = circle_centre(points)
    found = np.square(residuals(centre, points)).sum()
    assert found < np.square(residuals(np.array([1.0, 2.0]), points)).sum()
    assert found <= smallest(points) * (1.0 + 1e-6)


@pytest.mark.parametrize("bend", [0.0, 1e-7])
def test_points_that_are_nearer_to_a_line_than_to_a_circle_are_refused(bend):
    x = np.linspace(-1.0, 1.0, 30)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(30) * (bend > 0.0)
    noise -= np.polyval(np.polyfit(x, noise, 2), x)  # no curvature of its own
    points = np.column_stack((x, bend * x**2 + noise, 0.0 * x))
    with pytest.raises(ValueError, match="line"):
        fit_circle(points, [0.0, 0.0, 1.0])


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
