"""An image of a sheet is read as the deviation across each contour."""

import numpy as np
import pytest

from armside.sim.notes import Cause
from armside.sim.part.arcs import MM
from armside.sim.scan.reading import EDGE, SCALE, UNCALIBRATED, SheetScan, read_scan
from armside.sim.scan.virtual import Process, Scanner

from .sheets import DRAWING, MIDDLE, SIZE, circle, deviation, image, polygon

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


@pytest.mark.parametrize("width", [0.1, 0.215, 0.4])
def test_an_open_kerf_gives_the_beam(width):
    """Of thin steel, of the default beam, of a wide one [mm]."""
    scan = read_scan(image(process=Process(beam=width * MM, wave=0.0, roughness=0.0)), DRAWING)
    assert scan.beam_measured
    assert scan.beam == pytest.approx(width * MM, abs=1e-6)
    assert np.abs(errors(scan)["circle"].mean()) < 1e-6


def test_a_beam_that_is_given_counts_and_its_difference_is_said():
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


def on_circle(degrees: float, radius: float, turned: float) -> tuple[float, float]:
    """Place in the image [m] of a point of the circle's edge in the sheet turned by `turned`."""
    c, s = np.cos(np.radians(turned)), np.sin(np.radians(turned))
    p = radius * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    x, y = 0.5 * np.array(SIZE) + np.array([[c, -s], [s, c]]) @ (p - MIDDLE)
    return float(x), float(y)


def gap(scan: SheetScan, degrees: float) -> float:
    """Length [m] that is missing around a place of the circle."""
    s = np.radians(degrees) * 8 * MM
    read = scan.contours["circle"].arc_length
    return float(read[read > s].min() - read[read < s].max())


@pytest.mark.parametrize(
    ("grey", "radius"),
    [(40.0, 0.3), (40.0, 0.8), (190.0, 0.3), (120.0, 0.2)],
    ids=["tear", "large tear", "burr", "dust"],
)
def test_what_is_torn_burred_or_covered_is_left_out_with_a_note(grey, radius):
    spot = (*on_circle(60.0, 8.1 * MM, 7.0), radius * MM, grey)
    scan = read_scan(image(spots=(spot,)), DRAWING)
    assert np.sqrt(np.mean(errors(scan)["circle"] ** 2)) < PIXEL_AND_NOISE
    assert 0.8 * radius * MM < gap(scan, 60.0) < 3.0 * radius * MM + 0.4 * MM
    (note,) = [n for n in scan.notes if "left out" in n.text]
    assert note.cause is Cause.SCAN
    assert note.text.startswith("circle: ")


def test_a_contour_of_which_too_little_is_seen_is_refused():
    spots = tuple((*on_circle(d, 8.1 * MM, 7.0), 0.4 * MM, 120.0) for d in range(0, 360, 7))
    with pytest.raises(ValueError, match="circle is seen along"):
        read_scan(image(spots=spots), DRAWING)


def test_the_stated_noise_is_that_of_a_bin():
    """The roughness of an edge, means over 0.2 mm: 4 um correlated over 0.1 mm."""
    scan = read_scan(image(process=Process(wave=0.0, roughness=4e-6)), DRAWING)
    actual = np.std(errors(scan)["circle"])
    stated = np.sqrt(scan.contours["circle"].noise ** 2 - UNCALIBRATED**2 - EDGE**2)
    assert 0.7 * actual < stated < 1.3 * actual


def test_a_scanner_that_is_six_per_mille_off_is_said():
    """A cheap one, nobody calibrated: its scale is in doubt by what was found."""
    wide = {"a": circle(0, 0, 6), "b": circle(70, 0, 8), "mark": circle(60, 12, 2)}
    options = {"middle": np.array([33, 3]) * MM, "size": (100 * MM, 40 * MM), "drawing": wide}
    scan = read_scan(image(2.0, scanner=Scanner(scale=(6e-3, 6e-3)), **options), wide)
    assert scan.scale == pytest.approx(6e-3, rel=0.05)
    assert any("0.60 % larger" in note.text for note in scan.notes)
    good = read_scan(image(2.0, **options), wide)
    assert good.scale == SCALE
    assert not any("larger" in note.text for note in good.notes)


def test_a_part_whose_path_runs_half_a_beam_beside_its_drawing_has_no_error():
    """Its edges lie where they are drawn: as a beam without a width would leave them."""
    drawn = {"outer": circle(9, 2, 22)} | {n: c for n, c in DRAWING.items() if n != "kerf"}
    process = Process(wave=0.0, roughness=0.0, beam=0.0)
    taken = image(drawing=drawn, pieces=("outer",), process=process)
    for edges, half in ((True, 0.0), (False, 0.1 * MM)):
        scan = read_scan(taken, drawn, pieces=("outer",), edges=edges)
        for name, off in (("circle", -half), ("outer", half)):
            assert scan.contours[name].deviation.mean() == pytest.approx(off, abs=5e-6)
