"""An image of a sheet is read as the deviation across each contour."""

import numpy as np
import pytest

from armside.sim.part.arcs import MM
from armside.sim.scan.reading import SheetScan, read_scan
from armside.sim.scan.virtual import Process

from .sheets import DRAWING, circle, deviation, image, polygon

PIXEL_AND_NOISE = 1.5e-6
"""[m] RMS, of the image alone: docs/scan.md, 0.8 to 1.4 um in the trial."""


def errors(scan: SheetScan) -> dict[str, np.ndarray]:
    """Of the deviation [m] along each contour, but for a motion of all: a scan places the sheet by
    what was cut, so the truth's own place is not in it."""
    off, J = list[np.ndarray](), list[np.ndarray]()
    for name, read in scan.contours.items():
        p = DRAWING[name].point(read.arc_length)
        t = DRAWING[name].tangent(read.arc_length)
        J.append(np.column_stack([t[:, 1], -t[:, 0], -np.einsum("ij,ij->i", p, t)]))
        off.append(read.deviation - deviation(name, read.arc_length))
    motion = np.linalg.lstsq(np.vstack(J), np.concatenate(off), rcond=None)[0]
    return {name: e - A @ motion for name, e, A in zip(scan.contours, off, J, strict=True)}


@pytest.mark.parametrize(
    ("degrees", "options"),
    [
        (7.0, {}),
        (-133.0, {}),
        (90.0, {"greys": (50.0, 220.0)}),
        (40.0, {"mirrored": True}),
    ],
    ids=["upright", "turned", "bright ground", "mirrored"],
)
def test_a_sheet_is_read_whatever_its_angle_greys_and_face(degrees, options):
    scan = read_scan(image(degrees, **options), DRAWING)
    for name, error in errors(scan).items():
        assert np.sqrt(np.mean(error**2)) < PIXEL_AND_NOISE
        covered = len(scan.contours[name].arc_length) * 0.2 * MM / DRAWING[name].length
        assert covered > (0.85 if name == "kerf" else 0.99)
    angle = (np.degrees(scan.placement[2]) - degrees + 180.0) % 360.0 - 180.0
    assert abs(angle) < 0.1  # the wave turns the square by 0.03 deg
    assert any("mirrored" in note.text for note in scan.notes) == bool(options.get("mirrored"))


def test_an_open_kerf_gives_the_beam():
    scan = read_scan(image(process=Process(error=15e-6, wave=0.0, roughness=0.0)), DRAWING)
    assert scan.beam_measured
    assert scan.beam == pytest.approx(0.215 * MM, abs=1e-6)
    # A beam that is assumed 15 um too narrow makes holes 15 um too large in diameter.
    assumed = read_scan(
        image(process=Process(error=15e-6, wave=0.0, roughness=0.0)), DRAWING, beam=0.2 * MM
    )
    assert not assumed.beam_measured
    assert errors(assumed)["circle"].mean() == pytest.approx(7.5e-6, abs=1e-6)
    assert any("0.215" in note.text for note in assumed.notes)


def test_the_edge_of_a_piece_lies_half_a_beam_inside():
    drawing = {
        "outline": polygon((-12, -12), (30, -12), (30, 14), (-12, 14)),
        **{name: DRAWING[name] for name in ("circle", "square", "mark")},
    }
    seen = image(-20.0, drawing=drawing, pieces=["outline"])
    scan = read_scan(seen, drawing, pieces=["outline"])
    assert abs(np.mean(scan.contours["outline"].deviation)) < 1e-6
    with pytest.raises(ValueError, match="opposite greys"):
        read_scan(seen, drawing)


@pytest.mark.parametrize(
    ("drawing", "said"),
    [
        ({"circle": circle(9, 2, 10)}, "mark"),
        ({"a": circle(0, 0, 8), "b": circle(20, 0, 8)}, "mirrored"),
        ({"square": polygon((0, 0), (16, 0), (16, 16), (0, 16))}, "mark"),
    ],
    ids=["circle", "two circles", "square"],
)
def test_a_drawing_without_a_mark_is_refused(drawing, said):
    with pytest.raises(ValueError, match=said):
        read_scan(image(drawing=drawing), drawing)
