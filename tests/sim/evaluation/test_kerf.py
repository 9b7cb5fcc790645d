"""A beam sweeps what it sweeps: edges of cuts whose shape is known."""

import numpy as np
import pytest

from armside.sim.evaluation.kerf import kerf
from armside.sim.motion.contour import Circle, hexagon, slot, square

BEAM = 2e-4
SCALLOP = BEAM / 2 / 3000
"""What the edges of a path sampled by discs lack."""


def turn(shape, n=2000):
    return shape.point(np.linspace(0.0, shape.length, n, endpoint=False))


@pytest.mark.parametrize(
    "shape", [Circle(0.005), square(0.02, 0.003), slot(0.03, 0.01), hexagon(0.02, 0.002)]
)
def test_a_perfect_cut_is_as_wide_as_the_beam(shape):
    cut = kerf(shape, turn(shape, 20_000), BEAM)
    np.testing.assert_allclose(cut.outer, BEAM / 2, rtol=0, atol=SCALLOP)
    np.testing.assert_allclose(cut.inner, -BEAM / 2, rtol=0, atol=SCALLOP)
    assert cut.roundness < 2 * SCALLOP


def test_an_enlarged_or_displaced_hole_is_round():
    circle = Circle(0.005)
    large = kerf(circle, turn(Circle(0.0051)), BEAM)
    np.testing.assert_allclose(large.outer, BEAM / 2 + 1e-4, rtol=0, atol=2 * SCALLOP)
    assert large.roundness < 2 * SCALLOP
    shifted = kerf(circle, turn(circle) + np.array([5e-5, -3e-5]), BEAM)
    assert np.ptp(shifted.outer) > 1e-4
    assert shifted.roundness < 0.5e-6  # distances along normals of the other circle: 2nd order


def test_roundness_of_an_oval_hole_is_the_difference_of_its_half_axes():
    angle = np.linspace(0.0, 2 * np.pi, 4000, endpoint=False)
    oval = np.column_stack([5.1e-3 * np.cos(angle), 4.9e-3 * np.sin(angle)])
    cut = kerf(Circle(0.005), oval, BEAM)
    assert cut.roundness == pytest.approx(2e-4, rel=0.01)


def test_the_hole_of_a_contour_that_is_cut_twice_has_the_edge_of_its_outer_turn():
    angle = np.linspace(0.0, 4 * np.pi, 8000, endpoint=False)
    second = angle >= 2 * np.pi  # oval and outside; the piece has the first, which is round
    radius = 0.005 + 1e-4 * second * (1.0 + 0.5 * np.cos(2 * angle))
    path = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    assert kerf(Circle(0.005), path, BEAM).roundness == pytest.approx(1e-4, rel=0.02)


def test_every_point_of_the_edges_is_half_a_beam_from_the_path():
    """Whatever the path: nothing within reach of the beam stands, nothing beyond it falls."""
    shape = square(0.02, 0.003)
    s = np.linspace(0.0, shape.length, 4000, endpoint=False)
    tangent = shape.tangent(s)
    outwards = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    wave = 3e-4 * np.sin(60 * np.pi * s / shape.length)
    path = shape.point(s) + wave[:, np.newaxis] * outwards
    cut = kerf(shape, path, BEAM)
    for edge in (cut.edge(cut.outer), cut.edge(cut.inner)):
        distance = np.linalg.norm(edge[:, np.newaxis] - path, axis=2).min(axis=1)
        # Path samples are up to 26 um apart: the nearest one can be 0.85 um beyond the path itself.
        np.testing.assert_allclose(distance, BEAM / 2, rtol=0, atol=0.9e-6)


def test_samples_farther_apart_than_the_beam_is_wide_are_joined_by_straight_lines():
    circle = Circle(0.005)
    cut = kerf(circle, turn(circle, 100), BEAM)
    sagitta = 0.005 * (1.0 - np.cos(np.pi / 100))
    assert BEAM / 2 - sagitta - SCALLOP < cut.outer.min() < BEAM / 2 - 0.9 * sagitta
    assert cut.outer.max() < BEAM / 2 + 1e-9


def test_a_cut_that_does_not_close_is_wider_at_its_seam():
    circle = Circle(0.005)
    angle = np.linspace(0.0, 2 * np.pi, 4000, endpoint=False)
    spiral = (5e-3 + 2e-4 * angle / (2 * np.pi))[:, np.newaxis] * np.column_stack(
        [np.cos(angle), np.sin(angle)]
    )
    cut = kerf(circle, spiral, BEAM)
    assert cut.width.max() == pytest.approx(BEAM + 2e-4, rel=0.02)
    assert np.median(cut.width) == pytest.approx(BEAM, rel=0.01)


def test_an_open_cut_is_not_closed_across_the_sheet():
    """A quarter of a circle, whose chord is up to 1.5 mm from it."""
    angle = np.linspace(0.0, 0.5 * np.pi, 2000)
    quarter = 5e-3 * np.column_stack([np.cos(angle), np.sin(angle)])
    cut = kerf(Circle(0.005), quarter, BEAM, closed=False)
    np.testing.assert_allclose(cut.width[2:178], BEAM, rtol=0, atol=2 * SCALLOP)
    assert np.isnan(cut.width[182:-2]).all()


def test_a_path_with_gaps_leaves_no_edge():
    path = turn(Circle(0.005))
    path[7] = np.nan
    cut = kerf(Circle(0.005), path, BEAM)
    assert np.isnan(cut.outer).all()
    assert np.isnan(cut.roundness)


def test_a_beam_has_a_width():
    with pytest.raises(ValueError, match="beam must be > 0 m"):
        kerf(Circle(0.005), turn(Circle(0.005)), 0.0)
