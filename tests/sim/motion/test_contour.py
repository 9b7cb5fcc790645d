"""Contours close, are smooth, and know their nearest points and best fit."""

import numpy as np
import pytest

from armside.sim.cell import TOOL_QUATERNION
from armside.sim.motion.contour import ArcsAndLines, Circle, hexagon, slot, square
from armside.sim.motion.path import CuttingPath, Plane
from armside.sim.motion.tool_motion import cut

SHAPES = {
    "circle": Circle(0.005),
    "square": square(0.02, 0.003),
    "hexagon": hexagon(0.02, 0.002),
    "slot": slot(0.03, 0.01),
}
EVERY_SHAPE = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())


@EVERY_SHAPE
def test_a_contour_is_smooth_and_parametrised_by_arc_length(shape):
    s, h = np.linspace(0.0, shape.length, 1000, endpoint=False), 1e-7
    difference = (shape.point(s + h) - shape.point(s - h)) / (2 * h)
    # Where a line meets an arc the difference is off by h / (4 radius) = 1e-5.
    np.testing.assert_allclose(shape.tangent(s), difference, rtol=0, atol=2e-5)
    np.testing.assert_allclose(np.linalg.norm(shape.tangent(s), axis=1), 1.0, rtol=0, atol=1e-14)


@EVERY_SHAPE
def test_a_contour_closes_starts_at_plus_x_and_turns_left(shape):
    np.testing.assert_allclose(shape.point(shape.length), shape.point(0.0), rtol=0, atol=1e-15)
    assert shape.point(0.0)[0] > 0.0
    assert shape.point(0.0)[1] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(shape.tangent(0.0), [0.0, 1.0], rtol=0, atol=1e-15)
    x, y = shape.point(np.linspace(0.0, shape.length, 10_001)).T
    area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
    assert area > 0.0


def test_sizes_are_those_asked_for():
    def extent(shape):
        return np.ptp(shape.point(np.linspace(0.0, shape.length, 100_001)), axis=0)

    np.testing.assert_allclose(extent(SHAPES["square"]), [0.02, 0.02], rtol=0, atol=1e-9)
    np.testing.assert_allclose(extent(SHAPES["slot"]), [0.03, 0.01], rtol=0, atol=1e-9)
    assert extent(SHAPES["hexagon"])[0] == pytest.approx(0.02, abs=1e-9)
    # Rounding a corner of a square by r saves (8 - 2 pi) r over four corners.
    assert SHAPES["square"].length == pytest.approx(0.08 - (8 - 2 * np.pi) * 0.003)
    assert SHAPES["slot"].length == pytest.approx(2 * 0.02 + np.pi * 0.01)
    assert [shape.smallest_radius for shape in SHAPES.values()] == pytest.approx(
        [0.005, 0.003, 0.002, 0.005]
    )


def test_a_polygon_that_is_all_corner_is_a_circle():
    round_square = square(0.02, 0.01)
    s = np.linspace(0.0, round_square.length, 100)
    np.testing.assert_allclose(round_square.point(s), Circle(0.01).point(s), rtol=0, atol=1e-15)


@EVERY_SHAPE
def test_the_nearest_point_is_nearer_than_any_other(shape):
    p = np.random.default_rng(2).uniform(-0.02, 0.02, (300, 2))
    found = np.linalg.norm(p - shape.point(shape.nearest(p)), axis=1)
    dense = shape.point(np.linspace(0.0, shape.length, 5001))
    brute = np.linalg.norm(p[:, np.newaxis] - dense, axis=2).min(axis=1)
    # The dense points are up to 20 um apart.
    np.testing.assert_allclose(found, brute, rtol=0, atol=2e-5)
    assert np.all(found <= brute + 1e-12)


@EVERY_SHAPE
def test_every_shape_is_cut_at_constant_speed_within_the_acceleration_of_its_bends(shape):
    motion = cut(CuttingPath.around(shape, Plane(np.zeros(3))), TOOL_QUATERNION, 0.1)
    assert motion.reached_speed == pytest.approx(min(0.1, np.sqrt(1.3 * shape.smallest_radius)))
    first, last = motion.contour_time
    assert (last - first) * motion.reached_speed == pytest.approx(shape.length)


def test_bad_sizes_are_named():
    with pytest.raises(ValueError, match=r"corner radius must be above 0 and at most 0\.01 m"):
        square(0.02, 0.02)
    with pytest.raises(ValueError, match="corner radius"):
        hexagon(0.02, 0.0)
    with pytest.raises(ValueError, match="longer than wide"):
        slot(0.01, 0.01)
    with pytest.raises(ValueError, match="size must be > 0"):
        square(-0.02, 0.001)


def test_a_chain_that_does_not_close_is_refused():
    with pytest.raises(ValueError, match="does not close"):
        ArcsAndLines((0.0, 0.0), ((0.01, 0.0), (np.pi * 0.005, 200.0)))
    with pytest.raises(ValueError, match="longer than 0 m"):
        ArcsAndLines((0.0, 0.0), ((0.0, 1.0),))
