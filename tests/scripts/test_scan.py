"""`armside scan calibrate` and `armside scan read`."""

import csv
import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from PIL.ImageCms import ImageCmsProfile, createProfile
from PIL.PngImagePlugin import PngInfo
from tests.sim.scan.sheets import DRAWING, deviation, drawing_file, image, save
from tests.sim.scan.test_calibration import CHEAP, scan_of_grid

from armside.sim.part.arcs import MM
from armside.sim.scan.calibration import image_by, read_calibration
from armside.sim.scan.drawing import read_drawing
from armside.sim.scan.virtual import Process

NAMES = dict(zip(("CIRCLE #2F", "LWPOLYLINE #30", "CIRCLE #31", "LWPOLYLINE #32"), DRAWING,
                 strict=True))  # fmt: skip
ROUGH = 5e-6
"""[m], what a scan of an ideal edge leaves, and the place of the sheet."""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A drawing, a scan of its sheet, and one of a grid."""
    folder = tmp_path_factory.mktemp("scan")
    drawing_file(folder / "sheet.dxf")
    save(image(process=Process(wave=0.0, roughness=0.0, error=8e-6)), folder / "part.png")
    save(scan_of_grid(8.0), folder / "grid.png")
    return folder


def test_a_scan_is_read_into_a_table_a_summary_and_a_picture(files, summary_of, tmp_path):
    line = f"scan read {files / 'part.png'} --contours {files / 'sheet.dxf'} --drawn beam --out out"
    found = summary_of(line)
    assert found["beam_measured"]
    assert found["beam"] == pytest.approx(0.208 * MM, abs=1e-6)
    assert found["scale"] == 1e-3
    assert np.degrees(found["placement"][2]) == pytest.approx(7.0, abs=0.1)
    assert 0.0 < found["placement"][0] < 60 * MM
    for of in found["contours"]:
        name = NAMES[of["contour"]]
        s = np.linspace(0.0, DRAWING[name].length, 1000)
        d = deviation(name, s)
        assert of["length"] == pytest.approx(DRAWING[name].length)
        assert of["rms"] == pytest.approx(np.sqrt(np.mean(d**2)), abs=2 * ROUGH)
        assert of["max"] == pytest.approx(np.abs(d).max(), abs=4 * ROUGH)
        assert 10e-6 < of["noise"] < 12e-6  # of a scanner that nobody calibrated
        assert (of["size_error"] is None) == (name == "kerf")
        assert abs(of["size_error"] or 0.0) < ROUGH
    with (tmp_path / "out/deviation.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    circle = np.array(
        [(r["arc_length_mm"], r["deviation_mm"]) for r in rows if r["contour"] == "CIRCLE #2F"],
        dtype=float,
    ).T
    # The place of the sheet, by all contours, is in it: some um.
    assert np.abs(circle[1] * MM - deviation("circle", circle[0] * MM)).max() < 5 * ROUGH
    with Image.open(tmp_path / "out/scan.png") as picture:
        assert picture.size[0] > 600


def test_a_grid_makes_a_scanner_that_read_takes(files, summary_of, bad_input, tmp_path):
    found = summary_of(f"scan calibrate {files / 'grid.png'} --pitch 2.5 --out scanner.json")
    # What is taken off is the inverse of what the scanner does.
    assert found["scale_x"] == pytest.approx(-6e-3, rel=0.02)
    # A slope of the wobble, some um over 25 mm, is scale as well.
    assert found["scale_y"] == pytest.approx(1e-3, abs=3e-4)
    assert found["skew"] == pytest.approx(-CHEAP.skew, abs=2e-4)
    peak = sum(amplitude for amplitude, _, _ in CHEAP.wobble)
    assert 1.4 * peak < found["wobble"] < 2.2 * peak
    assert 0.3 * 1.4 * peak < found["wobble_sideways"] < 0.3 * 2.2 * peak
    assert found["residual"] < 3e-6
    low, high = found["heights"]
    assert 0.0 < low < 6 * MM < 26 * MM < high < 32 * MM
    kept = json.loads((tmp_path / "scanner.json/scanner.json").read_text())
    assert kept["matrix"][0][0] - 1.0 == found["scale_x"]
    line = f"scan read {files / 'part.png'} --contours {files / 'sheet.dxf'}"
    bad_input(f"{line} --scanner scanner.json --out out", "scan the same area")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("scan calibrate {0}/grid.png", "--pitch"),
        ("scan calibrate {0}/grid.png --pitch 0.5", "pitch must be 2 to 20 mm"),
        ("scan calibrate {0}/part.png --pitch 5", "cells"),
        ("scan calibrate --pitch 5", "reads an image"),
        ("scan calibrate {0}/grid.png --pitch 5 --beam 0.2", "beam is of armside scan read"),
        ("scan read {0}/part.png", "--contours"),
        ("scan read {0}/part.png {0}/part.png --contours {0}/sheet.dxf", "one image"),
        ("scan read {0}/sheet.dxf --contours {0}/sheet.dxf", "cannot identify"),
        ("scan read {0}/none.png --contours {0}/sheet.dxf", "does not exist"),
        ("scan read {0}/part.png --contours {0}/sheet.dxf --dpi 100", "dpi must be"),
        ("scan read {0}/part.png --contours {0}/sheet.dxf --dpi 1100", "CIRCLE #2F"),
        ("scan read {0}/part.png --contours {0}/sheet.dxf --scanner {0}/sheet.dxf", "sheet.dxf"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_line(files, bad_input, line, said):
    bad_input(f"{line.format(files)} --out out", said)


def test_the_missing_extra_is_named(files, monkeypatch, bad_input):
    monkeypatch.setitem(sys.modules, "skimage", None)
    said = "armside scan needs scikit-image: pip install 'armside[scan]'"
    bad_input(
        f"scan read {files / 'part.png'} --contours {files / 'sheet.dxf'} --drawn beam --out out",
        said,
    )


def test_a_file_without_resolution_asks_for_it(files, bad_input, tmp_path):
    with Image.open(files / "part.png") as picture:
        Image.fromarray(np.asarray(picture)).save(tmp_path / "bare.png")
    bad_input(
        f"scan read bare.png --contours {files / 'sheet.dxf'} --drawn beam --out out", "say --dpi"
    )


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "I;16"])
def test_colours_and_depths_say_the_same(files, mode, tmp_path, summary_of):
    """Colour of a scanner whose blue line sees no contrast; 16 bit."""
    with Image.open(files / "part.png") as picture:
        grey = np.asarray(picture)
    flat = np.full_like(grey, 120)
    coloured = Image.fromarray(np.dstack([grey, grey, flat]))
    made = {"I;16": lambda: Image.fromarray(grey.astype(np.uint16) * 257)}
    made.get(mode, lambda: coloured.convert(mode))().save(tmp_path / "a.tiff", dpi=(1200, 1200))
    found = summary_of(f"scan read a.tiff --contours {files / 'sheet.dxf'} --drawn beam --out out")
    assert found["beam"] == pytest.approx(0.208 * MM, abs=1e-6)


def coded(light, gamma):
    """Levels (rows, columns) uint8 of a file, of sRGB or of a gamma, by their definitions."""
    x = light / 255.0
    srgb = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.round(255.0 * (srgb if gamma is None else x ** (1.0 / gamma))).astype(np.uint8)


@pytest.mark.parametrize("said_by", ["sRGB", "gAMA", "profile", "nobody"])
def test_greys_that_are_not_linear_are_made_so(files, said_by, tmp_path, summary_of):
    """Half of a bent grey is not half of the light: it moves every edge by a part of its blur."""
    gamma = 1.8 if said_by == "gAMA" else None
    chunks, profile = PngInfo(), None
    if said_by == "sRGB":
        chunks.add(b"sRGB", b"\0")
    if said_by == "gAMA":
        chunks.add(b"gAMA", round(1e5 / 1.8).to_bytes(4, "big"))
    if said_by == "profile":
        profile = ImageCmsProfile(createProfile("sRGB")).tobytes()
    with Image.open(files / "part.png") as picture:
        bent = Image.fromarray(coded(np.asarray(picture), gamma))
        bent.save(tmp_path / "a.png", dpi=picture.info["dpi"], pnginfo=chunks, icc_profile=profile)
    line = f"scan read a.png --contours {files / 'sheet.dxf'} --drawn beam --out out"
    off = abs(summary_of(line)["beam"] - 0.208 * MM)
    assert off > 5e-6 if said_by == "nobody" else off < 1e-6


def test_a_scanner_keeps_the_gamma_that_is_said_of_it(summary_of, tmp_path):
    scan = scan_of_grid(8.0)
    file = save(replace(scan, grey=coded(scan.grey, 2.2)), tmp_path / "grid.png")
    summary_of("scan calibrate grid.png --pitch 2.5 --gamma 2.2 --out scanner")
    kept = read_calibration(tmp_path / "scanner")
    assert kept.gamma == 2.2
    bent, light = image_by(None, file).grey, image_by(kept, file).grey
    assert np.ptp(light.astype(int) - scan.grey) <= 2 < np.abs(bent.astype(int) - scan.grey).max()


def test_a_drawing_of_one_contour_is_a_hole_unless_it_is_said(tmp_path, armside, summary_of):
    corners = [[-12, -8], [14, -8], [14, 3], [2, 9], [-12, 9]]
    (tmp_path / "one.toml").write_text(f"corner = 1\npoints = {corners}\n")
    drawing = read_drawing(tmp_path / "one.toml").contours
    for name, pieces, word in (("hole", [], ""), ("piece", list(drawing), "--piece")):
        seen = image(30.0, drawing=drawing, middle=np.zeros(2), pieces=pieces)
        save(seen, tmp_path / f"{name}.png")
        (of,) = summary_of(
            f"scan read {name}.png --contours one.toml {word} --drawn beam --out {name}-read"
        )["contours"]
        assert abs(of["size_error"]) < 2e-6


@pytest.mark.parametrize("mode", ["1", "P", "F"])
def test_an_image_without_greys_is_refused(files, mode, tmp_path, bad_input):
    with Image.open(files / "part.png") as picture:
        suffix = "tiff" if mode == "F" else "png"
        picture.convert(mode).save(tmp_path / f"a.{suffix}", dpi=(1200, 1200))
    bad_input(
        f"scan read a.{suffix} --contours {files / 'sheet.dxf'} --drawn beam --out out", "grey"
    )
