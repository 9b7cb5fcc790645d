"""Whole drawings are read; what is wrong with a bad one is said in one line, with its place."""

import re

import numpy as np
import pytest
from ezdxf import units

from armside.sim.part.arcs import Chain
from armside.sim.part.curve import Kind
from armside.sim.part.drawing import DrawnChain, Reading, Unit
from armside.sim.part.part import part_of, read_part

from .drawings import bracket, flange, frame, new, save

INKSCAPE = """<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<!-- Created with Inkscape (http://www.inkscape.org/) -->
<svg width="120mm" height="80mm" viewBox="0 0 120 80" version="1.1" id="svg5"
   xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
   xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd"
   xmlns="http://www.w3.org/2000/svg">
  <sodipodi:namedview id="namedview7" pagecolor="#ffffff" inkscape:document-units="mm" />
  <defs id="defs2" />
  <g inkscape:label="Cut" inkscape:groupmode="layer" id="layer1" transform="translate(10,10)">
    <path style="fill:none;stroke:#000000;stroke-width:0.265" id="path1" sodipodi:nodetypes="cc"
       d="m 5,0 h 90 a 5,5 0 0 1 5,5 v 50 a 5,5 0 0 1 -5,5 H 5
           A 5,5 0 0 1 0,55 V 5 A 5,5 0 0 1 5,0 z"/>
    <circle cx="20" cy="30" r="6" id="path2" />
    <g id="g1" transform="rotate(90,50,30)"><ellipse cx="50" cy="30" rx="8" ry="4" id="path3" /></g>
    <rect width="12" height="20" x="74" y="20" ry="2" id="rect1" />
    <path id="path4" d="m 60,50 c 2,-4 8,-4 10,0 q -5,6 -10,0 z" />
  </g>
  <g inkscape:label="Notes" inkscape:groupmode="layer" id="layer2">
    <text x="5" y="5" id="text1"><tspan id="tspan1">M6</tspan></text>
  </g>
</svg>
"""


def read(document, folder, **reading):
    return read_part(save(document, folder), Reading(**reading))


def read_inkscape(folder, text=INKSCAPE, layers=("Cut",), unit=None):
    (folder / "part.svg").write_text(text)
    return read_part(folder / "part.svg", Reading(layers=layers, unit=unit))


def areas(part, kind):
    return sorted(1e6 * c.chain.area for c in part.contours if c.kind is kind)


def test_a_bracket_has_its_outline_and_ten_openings_and_names_the_text(tmp_path):
    part = read(bracket(new()), tmp_path, layers=("cut",))
    (outline,) = areas(part, Kind.OUTLINE)
    assert outline == pytest.approx(300.0 * 200.0 - (4.0 - np.pi) * 15.0**2, abs=1e-6)
    holes = areas(part, Kind.HOLE)
    assert len(holes) == 10
    np.testing.assert_allclose(holes[:8], 25.0 * np.pi, rtol=1e-9)
    assert holes[8] == pytest.approx(40.0 * 12.0 + 36.0 * np.pi, rel=1e-9)
    assert part.notes == ("layer NOTES is not cut: 1 entity",)
    np.testing.assert_allclose(1e3 * part.middle, [150.0, 100.0], atol=1e-6)


@pytest.mark.parametrize(
    ("layers", "said"),
    [
        ((), r"part.dxf: TEXT #.* on layer NOTES cannot be cut"),
        (("KUT",), r"no layer 'KUT'. Layers: 0, CUT, Defpoints, NOTES"),
    ],
)
def test_layers_that_cannot_be_cut_are_refused_by_name(layers, said, tmp_path):
    with pytest.raises(ValueError, match=said):
        read(bracket(new()), tmp_path, layers=layers)


def test_a_layer_that_is_off_is_not_cut_and_said(tmp_path):
    document = bracket(new())
    document.layers.get("NOTES").off()
    assert read(document, tmp_path).notes == ("layer NOTES is not cut: 1 entity",)


def test_a_flange_has_its_bore_and_24_holes(tmp_path):
    assert len(areas(read(flange(new()), tmp_path), Kind.HOLE)) == 25


def test_a_drawing_in_inches_is_read_in_metres(tmp_path):
    part = read(flange(new(unit=units.IN)), tmp_path)
    assert areas(part, Kind.OUTLINE) == pytest.approx([np.pi * 2540.0**2], rel=1e-9)


def test_an_svg_of_inkscape_has_its_shapes_the_right_way_up(tmp_path):
    part = read_inkscape(tmp_path)
    rounded = (4.0 - np.pi) / 4.0
    (outline,) = areas(part, Kind.OUTLINE)
    assert outline == pytest.approx(6000.0 - 100.0 * rounded, rel=1e-9)
    expected = sorted([36.0 * np.pi, 32.0 * np.pi, 240.0 - 16.0 * rounded])
    np.testing.assert_allclose(areas(part, Kind.HOLE)[1:], expected, atol=0.02)
    ellipse = next(c for c in part.contours if "path3" in c.name).chain
    np.testing.assert_allclose(1e3 * np.ptp(ellipse.polygon(), axis=0), [8.0, 16.0], atol=2e-3)
    small = next(c for c in part.contours if "path4" in c.name).chain
    assert 1e3 * small.points[:, 1].max() < -55.0, "low in the picture, and y points up"
    with pytest.raises(ValueError, match="text #text1 on layer Notes cannot be cut"):
        read_inkscape(tmp_path, layers=())
    without = INKSCAPE.replace('width="120mm"', 'width="120"')
    with pytest.raises(ValueError, match=r"unit is in doubt: its width is 120, .*--units mm or"):
        read_inkscape(tmp_path, without)
    again = read_inkscape(tmp_path, without, unit=Unit.MILLIMETRE)
    assert areas(again, Kind.OUTLINE) == pytest.approx([outline])


def test_shapes_without_an_id_have_names_of_their_own(tmp_path):
    circles = "".join(f'<circle cx="{x}" cy="15" r="3" />' for x in (20, 80))
    text = INKSCAPE.replace('<path style="fill', circles + '<path style="fill')
    names = [contour.name for contour in read_inkscape(tmp_path, text).contours]
    assert len(set(names)) == len(names) == 7
    assert {"circle 1 (without id)", "circle 2 (without id)"} < set(names)


def test_a_shape_of_zero_length_in_an_svg_is_refused_with_its_place(tmp_path):
    point = '<line x1="20" y1="15" x2="20" y2="15" id="dot" />'
    said = r"line #dot on layer Cut: it has zero length at \(30, -25"
    with pytest.raises(ValueError, match=said):
        read_inkscape(tmp_path, INKSCAPE.replace("<path style", point + "<path style"))


def test_entities_of_one_block_have_names_of_their_own(tmp_path):
    document = new()
    frame(document.modelspace())
    block = document.blocks.new("B")
    for x in (0.0, 10.0):
        block.add_circle((x, 0), 2.0)
    document.modelspace().add_blockref("B", (20, 20))
    names = [contour.name for contour in read(document, tmp_path).contours]
    assert len(set(names)) == len(names) == 3


def test_elements_of_a_namespace_that_is_not_known_are_said(tmp_path):
    foreign = '<cam:drill xmlns:cam="http://example.org/cam" x="1"/></svg>'
    notes = read_inkscape(tmp_path, INKSCAPE.replace("</svg>", foreign)).notes
    assert "elements of namespace http://example.org/cam that are not cut: 1" in notes
    assert not [note for note in read_inkscape(tmp_path).notes if "names" in note]


def test_a_contour_in_toml_is_a_part(tmp_path):
    (tmp_path / "c.toml").write_text("corner = 2\npoints = [[0, 0], [20, 0], [20, 10], [0, 10]]")
    area = 200.0 - 4.0 * (4.0 - np.pi)
    assert areas(read_part(tmp_path / "c.toml"), Kind.OUTLINE) == pytest.approx([area])


def draw_gap(space, gap):
    for a, b in [((20, 10), (40, 10)), ((40, 10), (40, 20)), ((40, 20), (20, 10 + gap))]:
        space.add_line(a, b)


@pytest.mark.parametrize("gap", [0.04, 1e-4])
def test_ends_within_the_tolerance_are_joined(gap, tmp_path):
    """A gap of rounding is not noted."""
    document = new()
    frame(document.modelspace())
    draw_gap(document.modelspace(), gap)
    part = read(document, tmp_path)
    assert areas(part, Kind.HOLE) == pytest.approx([100.0], rel=1e-2)
    said = r"a gap of 0.04 mm at \(20, 10(\.04)?\) mm is closed, between LINE #\w+ and LINE #\w+"
    assert [bool(re.fullmatch(said, note)) for note in part.notes] == [True] * (gap == 0.04)


BAD = {
    "open by 0.3 mm": (
        lambda s: draw_gap(s, 0.3),
        r"the contour is open by 0.3 mm at \(20, 10(\.3)?\) mm, between LINE #\w+ and LINE #\w+",
    ),
    "crosses itself": (
        lambda s: s.add_lwpolyline([(10, 10), (30, 30), (30, 10), (10, 30)], close=True),
        r"LWPOLYLINE #\w+ crosses itself at \(20, 20\) mm",
    ),
    "two that cross": (
        lambda s: (s.add_circle((20, 20), 5.0), s.add_circle((26, 20), 5.0)),
        r"CIRCLE #\w+ and CIRCLE #\w+ cross or touch at \(23, (16|24)\) mm",
    ),
    "one on another": (
        lambda s: (s.add_circle((20, 20), 5.0), s.add_circle((20, 20), 5.0)),
        r"CIRCLE #\w+ and CIRCLE #\w+ lie on each other at",
    ),
    "one beside another": (
        lambda s: (s.add_circle((20, 20), 10.0), s.add_circle((20, 20), 10.002)),
        r"CIRCLE #\w+ and CIRCLE #\w+ are 0.002 mm apart at \([-\d.]+, [-\d.]+\) mm: drawn twice",
    ),
    "hole outside": (
        lambda s: s.add_circle((150, 20), 5.0),
        r"CIRCLE #\w+ at \(155, 20\) mm lies outside the outline, LINE #\w+ and 3 more",
    ),
    "no length": (
        lambda s: s.add_line((7, 8), (7, 8)),
        r"LINE #\w+ has zero length at \(7, 8\) mm",
    ),
    "no length of a polyline": (
        lambda s: s.add_lwpolyline([(7, 8), (7, 8)]),
        r"LWPOLYLINE #\w+ on layer 0: it has zero length at \(7, 8\) mm",
    ),
    "no radius": (
        lambda s: s.add_circle((7, 8), 0.0),
        r"CIRCLE #\w+ on layer 0: its radius is 0, at \(7, 8\) mm",
    ),
    "three ends": (
        lambda s: [s.add_line((20, 20), end) for end in ((30, 20), (20, 30), (15, 15))],
        r"more than two ends meet at \(20, 20\) mm: those of LINE #\w+, LINE #\w+, LINE #\w+",
    ),
    "not flat": (lambda s: s.add_line((7, 8, 0), (9, 8, 1)), r"not drawn in the x-y plane"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_drawing_is_refused_in_one_line_with_its_place(case, tmp_path):
    draw, said = BAD[case]
    document = new()
    frame(document.modelspace())
    draw(document.modelspace())
    with pytest.raises(ValueError, match=rf"^part\.dxf: .*{said}") as caught:
        read(document, tmp_path)
    assert "\n" not in str(caught.value)


def test_a_drawing_without_a_closed_contour_says_how_far_its_ends_are_apart():
    points = np.array([[0.02, 0.01], [0.04, 0.01], [0.04, 0.02], [0.02, 0.0103]])
    chain = DrawnChain(Chain(points, np.zeros(3)), "LINE #1", "")
    said = r"LINE #1 ends 0\.3 mm apart at \(20, 10\) mm and \(20, 10\.3\) mm"
    with pytest.raises(ValueError, match=f"no contour is closed; {said}"):
        part_of([chain])


@pytest.mark.parametrize("unit", [0, units.M], ids=["no unit", "metres of a part in mm"])
def test_a_unit_in_doubt_is_refused_unless_it_is_said(unit, tmp_path):
    document = flange(new(unit=unit))
    with pytest.raises(ValueError, match=r"unit.*say --units mm or --units inch"):
        read(document, tmp_path)
    assert read(document, tmp_path, unit=Unit.MILLIMETRE).box[1, 0] == pytest.approx(0.1)


def test_units_that_contradict_each_other_are_refused(tmp_path):
    document = flange(new(unit=units.IN))
    document.header["$MEASUREMENT"] = 1
    with pytest.raises(ValueError, match=r"\$INSUNITS says .*, \$MEASUREMENT says metric"):
        read(document, tmp_path)


def test_what_is_no_drawing_is_said(tmp_path):
    for name in ("a.dxf", "a.svg"):
        (tmp_path / name).write_text("hello")
        with pytest.raises(ValueError, match=rf"^{name}: this is no (DXF|SVG) drawing"):
            read_part(tmp_path / name)


def test_area_and_length_of_arcs_hold_against_their_polygon():
    chain = Chain(np.array([[0, 0], [3, 0], [3, 2], [0, 0.0]]), np.array([0.3, -0.6, 0.0]))
    x, y = chain.polygon(1e-10).T
    assert chain.area == pytest.approx(0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]), rel=1e-6)
    assert chain.length == pytest.approx(np.hypot(np.diff(x), np.diff(y)).sum(), rel=1e-6)
