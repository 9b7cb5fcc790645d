"""The least-squares circle is the minimum: on turns, on arcs, and with a point on its centre."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from armside.ilc.measures.norms import circle_centre, fit_circle


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


@pytest.mark.parametrize("seed", range(40))
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


def test_a_path_and_its_moved_copy_have_the_same_centre():
    points = turn((0.0, 0.0), 0.005) + 1e-4 * np.random.default_rng(3).standard_normal((60, 2))
    shift = np.array([1.3, -0.7])
    moved = circle_centre(points + shift) - shift
    assert moved == pytest.approx(circle_centre(points), abs=1e-12)


@pytest.mark.parametrize("bend", [0.0, 1e-7])
def test_points_that_are_nearer_to_a_line_than_to_a_circle_are_refused(bend):
    x = np.linspace(-1.0, 1.0, 30)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(30) * (bend > 0.0)
    noise -= np.polyval(np.polyfit(x, noise, 2), x)  # no curvature of its own
    points = np.column_stack((x, bend * x**2 + noise, 0.0 * x))
    with pytest.raises(ValueError, match="line"):
        fit_circle(points, [0.0, 0.0, 1.0])
