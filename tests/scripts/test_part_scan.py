"""`armside cut --scan`: by hand, over files, as a person with a robot and a flatbed scanner."""

import json

import pytest
from PIL import Image

from armside.scripts.cutting import coupon

from .ran import ran

PLATE = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">
<g fill="none" stroke="black"><path d="M8 5h24v20h-24z"/><circle cx="14" cy="11" r="4"/>
<path d="M19 12h10v9h-10z"/></g></svg>"""
CUT = "plate.svg --speed 40 --corner 2 --pose p2 --measure scan"
BED = (0.030, 0.026)
"""[m], scanned; a coupon's is an A4's."""


def test_a_part_is_cut_scanned_and_cut_better(tmp_path, monkeypatch, bad_input):
    pytest.importorskip("svgelements")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(coupon, "SHEET", BED)
    (tmp_path / "plate.svg").write_text(PLATE, encoding="utf-8")
    mine = "--individual 7 --iterations 0 --draw-scan"
    first = ran(tmp_path / "part0", "cut", CUT, mine)
    found = ran(tmp_path / "run1", "cut", CUT, "--scan part0/part-scan.png")
    seen, true = found["scan"]["rms"], first["iterations"][0]["arm_rms_true"]
    assert seen == pytest.approx(true, rel=0.15)  # the place of the sheet is fitted otherwise
    assert found["scan"]["k"] == 0
    assert [each["contour"] for each in found["scan"]["contours"]] == [
        each["name"] for each in first["contours"]
    ]
    deviations = [each["rms"] for each in found["scan"]["contours"]]
    own = [each["iterations"][0]["arm_rms_true"] for each in first["contours"]]
    assert deviations == pytest.approx(own, rel=0.35)  # one place of the sheet, not of each contour
    most = [each["iterations"][0]["arm_maxdev_true"] for each in first["contours"]]
    assert [each["max"] for each in found["scan"]["contours"]] == pytest.approx(most, rel=0.35)
    assert all(3e-6 < each["noise"] < 3e-5 for each in found["scan"]["contours"])
    assert any("not calibrated" in note["text"] for note in found["notes"])
    with Image.open(tmp_path / "run1/scan.png") as picture:
        assert picture.size[0] > 600
    again = ran(tmp_path / "part1", "cut --from run1", mine)
    assert again["iterations"][0]["arm_rms_true"] < 0.35 * true
    bad_input("cut --from run1 --scan part0/part-scan.png", "is the scan of the part of k = 0")
    bad_input("cut --from run1 --scan part1/part-scan.png --speed 30", "had another speed")
    bad_input("cut --from run1 --scan part1/part-scan.png --plan-only", "leave out --plan-only")
    bad_input("cut --from run1 --scanner part1", "give --scan PART.png too")
    second = ran(tmp_path / "run2", "cut --from run1 --scan part1/part-scan.png")
    assert second["scan"]["k"] == 1
    assert second["scan"]["rms"] < 0.5 * seen
    kept = json.loads((tmp_path / "run2/scans.json").read_text(encoding="utf-8"))
    assert len(kept["digests"]) == 2
