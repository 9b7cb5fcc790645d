"""Error measures of thesis 9.3 on records and circles whose answer is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armside.ilc.measures.norms import (
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


def test_normalising_by_no_error_is_refused():
    with pytest.raises(ValueError, match="largest error without learning"):
        normalise(1.0, [0.0, 0.0])


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


def test_the_centre_minimises_the_radial_residual():
    rng = np.random.default_rng(4)
    flat = circle_points([0.0, 0, 0], [0, 0, 1], 5e-3) + rng.normal(0, 2e-4, (400, 3)) * [1, 1, 0]
    circle = fit_circle(flat, [0, 0, 1])
    best = np.std(circle.radii)
    for offset in rng.normal(0, 1e-5, (20, 2)):
        assert np.std(np.hypot(*(circle.in_plane - offset).T)) >= best


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((2, 3)), "M >= 3"),
        (np.outer(np.arange(5.0), [1, 2, 3]), "one line"),
        (1.7 + np.outer(np.linspace(0.0, 0.3, 99), [0.1, 0.7, 0.3]), "one line"),
        (np.full((5, 3), np.nan), "5 of 5 are not"),
    ],
)
def test_points_without_a_circle_are_refused(points, message):
    with pytest.raises(ValueError, match=message):
        fit_circle(points)
