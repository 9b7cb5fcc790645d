"""A scan drawn from the true path says where the beam was, and errs as it is told to."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.evaluation.tool_error import signed_distance
from armside.sim.motion.contour import Circle, hexagon, outward_normal, square
from armside.sim.scan.virtual_reading import (
    CALIBRATED,
    BeamPath,
    ScanErrors,
    placement,
    virtual_scan,
)

EXACT = ScanErrors(
    **dict.fromkeys(
        ("beam", "from_cut_to_cut", "edge", "roughness", "image", "scale", "skew"), 0.0
    ),
    wobble=(0.0, 0.0),
)
SHAPES = {"circle": (Circle(0.008), (0.0, 0.0)), "square": (square(0.016, 0.003), (0.03, 0.01))}
SWEPT = 1e-3
"""[m], beside start and end of a contour, where the end of a kerf is round."""


def sheet(x=0.0, y=0.0, angle=0.0):
    """Contours that wave by 50 um, of a drawing that lies elsewhere."""
    c, s = np.cos(angle), np.sin(angle)
    turn, found = np.array([[c, -s], [s, c]]), {}
    for name, (curve, middle) in SHAPES.items():
        along = np.linspace(0.0, curve.length, 2000)
        wave = 50e-6 * np.sin(6.0 * np.pi * along / curve.length)
        path = curve.point(along) + wave[:, None] * outward_normal(curve.tangent(along)) + middle
        found[name] = BeamPath(curve=curve, middle=middle, path=path @ turn.T + (x, y))
    return found


def inner(name, scan):
    """Arc lengths and deviations of a contour but for its ends."""
    seen, length = scan.contours[name], SHAPES[name][0].length
    use = (seen.arc_length > SWEPT) & (seen.arc_length < length - SWEPT)
    return seen.arc_length[use], seen.deviation[use]


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (0.4e-3, -0.7e-3, 3e-3)])
def test_without_errors_a_scan_reads_the_path_wherever_the_sheet_lay(place):
    cut = sheet(*place)
    scan = virtual_scan(cut, np.random.default_rng(0), EXACT)
    placed, _ = placement([(one.curve, one.middle, one.path) for one in cut.values()])
    for (name, one), points in zip(cut.items(), placed, strict=True):
        p = points - one.middle
        s, d = inner(name, scan)
        true = np.interp(s, one.curve.nearest(p)[:-1], signed_distance(one.curve, p)[:-1])
        assert np.abs(d - true).max() < 1.5e-6  # bins of 0.2 mm of a wave of 50 um


def test_edges_are_as_rough_as_estimated_and_sizes_off_by_the_scale():
    exact = virtual_scan(sheet(), np.random.default_rng(0), EXACT)
    for errors, low, high in (
        (CALIBRATED, 3e-6, 6e-6),
        (replace(EXACT, scale=1e-3), 0.5e-6, 40e-6),  # 1e-3 of 30 mm
    ):
        scan = virtual_scan(sheet(), np.random.default_rng(1), errors)
        off = np.concatenate([inner(n, scan)[1] - inner(n, exact)[1] for n in SHAPES])
        assert low < np.sqrt(np.mean(off**2)) < high


def test_a_kerf_is_wider_clockwise_by_the_difference_of_the_directions():
    width = 30e-6
    one = sheet()["circle"]
    back = replace(one, path=one.path[::-1], clockwise=True)
    errors = replace(EXACT, direction=width)
    read = [
        virtual_scan({"circle": each}, np.random.default_rng(0), errors) for each in (one, back)
    ]
    there, again = (scan.contours["circle"].deviation.mean() for scan in read)
    assert again - there == pytest.approx(0.5 * width, abs=0.5e-6)  # of a side


def test_a_symmetric_contour_a_good_part_of_its_size_away_is_not_turned_by_a_corner():
    """As a part's mark would not let it: a robot with geometry errors cuts 4 mm beside."""
    curve = hexagon(7e-3, 1e-3)
    s = np.linspace(0.0, curve.length, 500)
    bump = 50e-6 * np.exp(-(((s - 0.3 * curve.length) / 1e-3) ** 2))
    cut = curve.point(s) + bump[:, None] * outward_normal(curve.tangent(s))
    for away in ((0.0, 0.0), (-1.2e-3, 3.5e-3)):
        one = BeamPath(curve=curve, middle=(0.0, 0.0), path=cut + away)
        (seen,) = virtual_scan({"hexagon": one}, np.random.default_rng(0)).contours.values()
        found = seen.arc_length[seen.deviation.argmax()]
        assert found == pytest.approx(0.3 * curve.length, abs=1e-3)
