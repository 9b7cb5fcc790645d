"""The error of corners is that of corners, and of what overshoots behind them."""

import numpy as np
import pytest

from armside.sim.evaluation.contour_error import BEYOND, LARGEST_RADIUS, corner_error, in_corners
from armside.sim.part.arcs import arc, joined, line
from armside.sim.part.curve import ChainCurve

RADIUS, SIDE = 0.005, 0.1
BEND = 0.5 * np.pi * RADIUS


def stadium(radius):
    """Two lines of 100 mm joined by half circles."""
    low, high = [0.0, -radius], [SIDE, radius]
    right = arc((SIDE, 0.0), radius, -0.5 * np.pi, np.pi)
    left = arc((0.0, 0.0), radius, 0.5 * np.pi, np.pi)
    there = line(low, (SIDE, -radius))
    right.points[0], right.points[-1] = there.points[-1], high
    left.points[0], left.points[-1] = (0.0, radius), low
    return ChainCurve(joined([there, right, line(high, (0.0, radius)), left]))


def beside(curve, s, offset):
    tangent = curve.tangent(s)
    return curve.point(s) + offset[:, np.newaxis] * np.column_stack([tangent[:, 1], -tangent[:, 0]])


def test_a_corner_reaches_beyond_its_end_and_over_the_start_of_the_contour():
    curve = stadium(RADIUS)
    s = np.linspace(0.0, curve.length, 40001, endpoint=False)
    assert in_corners(curve, s).mean() * curve.length == pytest.approx(
        4 * BEND + 2 * BEYOND, rel=1e-3
    )
    assert in_corners(curve, np.array([0.9 * BEYOND])).all(), "behind the corner that closes it"
    assert not in_corners(curve, np.array([1.1 * BEYOND, SIDE - 1e-4])).any()


@pytest.mark.parametrize(("at", "seen"), [(SIDE + BEND, True), (0.5 * SIDE, False)])
def test_a_bump_counts_in_a_corner_and_not_on_a_straight(at, seen):
    curve = stadium(RADIUS)
    s = np.linspace(0.0, curve.length, 4000, endpoint=False)
    bump = 3e-5 * np.exp(-(((s - at) / 2e-3) ** 2))
    found = corner_error(curve, beside(curve, s, bump))
    assert found == pytest.approx(3e-5 if seen else 0.0, abs=1e-7)


def test_an_overshoot_behind_a_corner_belongs_to_it():
    curve = stadium(RADIUS)
    s = np.linspace(0.0, curve.length, 4000, endpoint=False)
    behind = SIDE + 2 * BEND
    bump = np.where((s > behind) & (s < behind + BEYOND), 2e-5, 0.0)
    assert corner_error(curve, beside(curve, s, bump)) == pytest.approx(2e-5, abs=1e-9)


def test_a_contour_without_tight_bends_has_no_corner():
    curve = stadium(1.1 * LARGEST_RADIUS)
    path = curve.point(np.linspace(0.0, curve.length, 500, endpoint=False))
    assert np.isnan(corner_error(curve, path))


def test_an_open_cut_has_no_corner_behind_its_end():
    bend = arc((0.0, RADIUS), RADIUS, -0.5 * np.pi, 0.5 * np.pi)
    curve = ChainCurve(joined([line((-SIDE, 0.0), bend.points[0]), bend]))
    s = np.array([1e-3, SIDE + 0.5 * BEND, curve.length])
    np.testing.assert_array_equal(in_corners(curve, s), [False, True, True])
