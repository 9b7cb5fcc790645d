"""A path is parametrised by its arc length, wherever its plane lies."""

import numpy as np
import pytest

from sim.motion.path import Circle, CuttingPath, Plane

TILTED = Plane.perpendicular_to([0.98, 0.01, -0.2], [1.3, 0.1, 1.6])


def a_path(plane=TILTED, lead=0.1):
    return CuttingPath.around(Circle(0.005), plane, lead=lead)


def test_the_tangent_is_the_derivative_of_the_position_by_arc_length():
    path = a_path()
    s, h = np.linspace(0.0, path.length, 200), 1e-6
    difference = (path.position(s + h) - path.position(s - h)) / (2 * h)
    # Truncation h^2 / (6 radius^2) = 7e-9, rounding eps / h = 4e-10.
    np.testing.assert_allclose(path.tangent(s), difference, rtol=0, atol=2e-8)
    np.testing.assert_allclose(np.linalg.norm(path.tangent(s), axis=1), 1.0, rtol=0, atol=1e-14)


def test_the_contour_is_one_full_turn_between_leads_of_a_tenth():
    path = a_path()
    turn = 2 * np.pi * 0.005
    assert path.contour_end - path.contour_start == pytest.approx(turn, rel=1e-14)
    assert path.contour_start == pytest.approx(0.1 * turn)
    assert path.length == pytest.approx(1.2 * turn)
    np.testing.assert_allclose(
        path.position(path.contour_start), path.position(path.contour_end), rtol=0, atol=1e-15
    )


def test_a_circle_in_the_base_plane_starts_at_plus_x_and_turns_counter_clockwise():
    centre, x, y = np.array([1.3, 0.2, 1.6]), np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    path = a_path(Plane(centre))
    np.testing.assert_allclose(path.position(0.0), centre + 0.005 * x, rtol=0, atol=1e-15)
    quarter = path.curve.length / 4
    np.testing.assert_allclose(path.position(quarter), centre + 0.005 * y, rtol=0, atol=1e-15)


def test_a_plane_perpendicular_to_an_axis_holds_points_at_height_zero():
    path = a_path()
    points = path.position(np.linspace(0, path.length, 50))
    axis = np.array([0.98, 0.01, -0.2]) / np.linalg.norm([0.98, 0.01, -0.2])
    np.testing.assert_allclose((points - TILTED.origin) @ axis, 0.0, rtol=0, atol=1e-15)
    assert TILTED.axes[2, 2] > 0.0
    np.testing.assert_allclose(TILTED.from_base(points)[:, 2], 0.0, rtol=0, atol=1e-15)


def test_a_plane_exists_for_every_normal_even_the_base_x_axis():
    for normal in ([1, 0, 0], [0, -1, 0], [0, 0, -1]):
        axes = Plane.perpendicular_to(normal, [0, 0, 0]).axes
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), rtol=0, atol=1e-15)
        assert np.linalg.det(axes) == pytest.approx(1.0)


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf])
def test_a_radius_that_is_not_positive_is_named(radius):
    with pytest.raises(ValueError, match="radius must be > 0 m"):
        Circle(radius)


def test_a_plane_refuses_axes_that_are_no_rotation():
    with pytest.raises(ValueError, match="rotation"):
        Plane(np.zeros(3), 2 * np.eye(3))
    with pytest.raises(ValueError, match="zero vector"):
        Plane.perpendicular_to([0, 0, 0], [0, 0, 0])
