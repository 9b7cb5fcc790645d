"""A path is parametrised by its arc length, wherever its plane lies."""

import numpy as np
import pytest

from armside.sim.motion.contour import Circle, square
from armside.sim.motion.path import CuttingPath, Plane

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
    assert path.lead_in == pytest.approx(0.1 * turn)
    assert path.length == pytest.approx(1.2 * turn)
    np.testing.assert_allclose(
        path.position(path.lead_in), path.position(path.lead_in + turn), rtol=0, atol=1e-15
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


@pytest.mark.parametrize("curve", [Circle(0.005), square(0.02, 0.003)], ids=["circle", "square"])
def test_a_spiral_lead_in_starts_inside_and_joins_the_contour_smoothly(curve):
    path = CuttingPath.around(curve, TILTED, lead=0.5, spiral=0.4)
    s, h = np.linspace(0.0, path.length, 400), 1e-7
    difference = (path.position(s[1:-1] + h) - path.position(s[1:-1] - h)) / (2 * h)
    # Arc length: the derivative is a unit vector, and the tangent; 2e-5 where lines meet arcs.
    np.testing.assert_allclose(difference, path.tangent(s[1:-1]), rtol=0, atol=2e-5)
    np.testing.assert_allclose(np.linalg.norm(difference, axis=1), 1.0, rtol=0, atol=1e-6)
    plane = TILTED.from_base(path.position(s))[:, :2]
    on_contour = np.linalg.norm(plane - curve.point(curve.nearest(plane)), axis=1)
    assert np.all(on_contour[s >= path.lead_in] < 1e-12)
    assert on_contour[0] > 0.3 * curve.smallest_radius
    begin = path.lead_in
    e = 1e-9
    for side in (begin - e, begin + e):
        np.testing.assert_allclose(path.position(side), path.position(begin), rtol=0, atol=2e-9)
        np.testing.assert_allclose(path.tangent(side), path.tangent(begin), rtol=0, atol=1e-6)


def test_a_spiral_starts_at_the_given_scale():
    path = CuttingPath.around(Circle(0.005), TILTED, lead=0.5, spiral=0.4)
    radius = np.linalg.norm(
        path.position(np.linspace(0.0, path.lead_in, 200)) - TILTED.origin, axis=1
    )
    assert radius[0] == pytest.approx(0.4 * 0.005, rel=1e-12)
    assert np.all(np.diff(radius) > 0.0)
    assert path.smallest_radius < 0.005


def test_a_spiral_too_short_to_reach_the_contour_names_its_least_length():
    path = CuttingPath.around(Circle(0.005), TILTED, lead=0.05, spiral=0.4)
    with pytest.raises(ValueError, match=r"too short to spiral from 0\.4 .* it needs 0\.003 m"):
        path.position(0.0)


def test_a_spiral_of_no_size_is_refused():
    with pytest.raises(ValueError, match="spiral must be between 0 and 1"):
        CuttingPath.around(Circle(0.005), TILTED, spiral=1.0)
