"""Every type of DXF entity is read with its length and area, or refused by name."""

import numpy as np
import pytest
from ezdxf.entities import factory
from ezdxf.entities.dxfgfx import DXFGraphic
from scipy.integrate import quad

from armside.sim.part.curve import Kind
from armside.sim.part.drawing import Reading, Unit
from armside.sim.part.dxf import READERS, drawing_of
from armside.sim.part.part import read_part

from .drawings import QUARTER, frame, new, save

VERSIONS = ["R12", "R2000", "R2018"]
SINCE_R2000 = ["R2000", "R2018"]
MILLIMETRES = Reading(unit=Unit.MILLIMETRE)
"""R12 has no unit of its own."""


def hole_of(document, folder):
    """The only contour besides the frame."""
    frame(document.modelspace())
    part = read_part(save(document, folder), MILLIMETRES)
    (found,) = (c for c in part.contours if c.kind is not Kind.OUTLINE)
    return found


def check(contour, length, area):
    """length [mm], area [mm^2]; 1 um is the tolerance of curves."""
    np.testing.assert_allclose(1e3 * contour.chain.length, length, rtol=1e-5)
    np.testing.assert_allclose(1e6 * contour.chain.area, area, atol=1e-3 * length)


def arc_and_line(space):
    """An arc above half a turn, closed by a line."""
    space.add_arc((20, 20), 5.0, 0.0, 270.0)
    space.add_line((20, 15), (25, 20))


EXACT = {
    "lines": (lambda space: frame(space, 20.0, 10.0, 5.0, 5.0), 60.0, 200.0),
    "circle": (lambda space: space.add_circle((20, 20), 5.0), 10.0 * np.pi, 25.0 * np.pi),
    "arc": (arc_and_line, 7.5 * np.pi + 5.0 * np.sqrt(2.0), 0.75 * 25.0 * np.pi + 12.5),
}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("shape", EXACT)
def test_lines_and_arcs_are_exact(version, shape, tmp_path):
    draw, length, area = EXACT[shape]
    document = new(version)
    draw(document.modelspace())
    hole = hole_of(document, tmp_path)
    check(hole, length, area)
    if shape == "circle":
        np.testing.assert_allclose(np.abs(hole.chain.curvature), 200.0, rtol=1e-12)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("extrusion", [(0, 0, 1), (0, 0, -1)], ids=["above", "below"])
def test_a_polyline_with_bulges_is_seen_from_above(version, extrusion, tmp_path):
    document = new(version)
    side = extrusion[2]
    rows = [(10 * side, 0, 0), (20 * side, 0, side * QUARTER), (25 * side, 5, 0), (10 * side, 5, 0)]
    # Mirrored by its extrusion: x and the bulge have their signs once more.
    attributes = {"extrusion": extrusion}
    space = document.modelspace()
    if version == "R12":
        space.add_polyline2d(rows, format="xyb", close=True, dxfattribs=attributes)
    else:
        space.add_lwpolyline(rows, format="xyb", close=True, dxfattribs=attributes)
    area = 50.0 + 25.0 * np.pi / 4.0
    hole = hole_of(document, tmp_path)
    check(hole, 10 + 2.5 * np.pi + 15 + 5, area)
    assert 1e3 * hole.chain.points[:, 0].max() == pytest.approx(25.0)


@pytest.mark.parametrize("version", SINCE_R2000)
def test_an_ellipse_has_its_length_and_area(version, tmp_path):
    document = new(version)
    document.modelspace().add_ellipse((30, 20), (12, 5), 0.4)
    a, b = 13.0, 5.2
    length = quad(lambda t: np.hypot(a * np.sin(t), b * np.cos(t)), 0.0, 2.0 * np.pi)[0]
    hole = hole_of(document, tmp_path)
    check(hole, length, np.pi * a * b)
    p = (hole.chain.polygon(1e-8) - [0.030, 0.020]) @ np.array([[12, -5], [5, 12]]) / 13.0
    form = np.hypot(p[:, 0] / a, p[:, 1] / b) * 1e3
    assert np.abs(form - 1.0).max() * b < 1.1e-3, "1 um, and the polygon's own"


@pytest.mark.parametrize("version", SINCE_R2000)
def test_a_spline_has_its_length_and_area(version, tmp_path):
    document = new(version)
    points = [(10, 10, 0), (30, 5, 0), (35, 25, 0), (12, 30, 0), (10, 10, 0)]
    spline = document.modelspace().add_cad_spline_control_frame(points)
    tool = spline.construction_tool()
    knots = tool.knots()
    u = np.linspace(knots[tool.order - 1], knots[-tool.order], 20001)
    x, y = np.array([(p.x, p.y) for p in list(tool.points(u))]).T
    area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
    check(hole_of(document, tmp_path), np.hypot(np.diff(x), np.diff(y)).sum(), abs(area))


@pytest.mark.parametrize("version", VERSIONS)
def test_a_block_is_taken_apart_at_its_place(version, tmp_path):
    document = new(version)
    document.layers.add("HOLES")
    block = document.blocks.new("B")
    block.add_circle((1, 0), 2.0)
    scale = {"xscale": 2.0, "yscale": 2.0, "rotation": 90.0, "layer": "HOLES"}
    document.modelspace().add_blockref("B", (20, 20), dxfattribs=scale)
    hole = hole_of(document, tmp_path)
    check(hole, 8.0 * np.pi, 16.0 * np.pi)
    assert hole.layer == "HOLES", "an entity on layer 0 of a block is on the layer of its insert"
    middle = 0.5 * (hole.chain.points.min(axis=0) + hole.chain.points.max(axis=0))
    np.testing.assert_allclose(1e3 * middle, [20.0, 22.0], atol=1e-6)


def test_a_stretched_block_makes_an_ellipse_of_a_circle(tmp_path):
    document = new()
    document.blocks.new("B").add_circle((0, 0), 2.0)
    document.modelspace().add_blockref("B", (20, 20), dxfattribs={"xscale": 3.0})
    hole = hole_of(document, tmp_path)
    assert 1e6 * hole.chain.area == pytest.approx(np.pi * 12.0, rel=1e-4)


def test_a_turned_block_in_a_stretched_one_is_skewed(tmp_path):
    """ezdxf moves the inner insert to another place, and stretches it without skewing it."""
    document = new()
    document.blocks.new("IN").add_lwpolyline([(3, 1), (5, 1), (5, 2), (3, 2)], close=True)
    document.blocks.new("OUT").add_blockref("IN", (5, 4), dxfattribs={"rotation": 30.0})
    stretch = {"xscale": 2.0, "yscale": 0.5}
    document.modelspace().add_blockref("OUT", (20, 20), dxfattribs=stretch)
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    corners = np.array([(3, 1), (5, 1), (5, 2), (3, 2)]) @ np.array([[c, s], [-s, c]]) + [5, 4]
    wanted = corners * [2.0, 0.5] + 20.0
    points = 1e3 * hole_of(document, tmp_path).chain.points[:-1]
    apart = np.linalg.norm(points[:, None] - wanted, axis=2).min(axis=0)
    np.testing.assert_allclose(apart, 0.0, atol=1e-6)


IN_R12 = ["POINT", "SOLID", "TRACE", "3DFACE", "TEXT", "SHAPE", "ATTDEF", "DIMENSION", "VIEWPORT"]
LATER = ["MTEXT", "HATCH", "MPOLYGON", "LEADER", "MLINE", "RAY", "XLINE", "WIPEOUT", "MESH"]
LATER += ["HELIX", "REGION", "3DSOLID", "BODY", "TOLERANCE", "MULTILEADER", "LIGHT", "SURFACE"]
LATER += ["PDFUNDERLAY", "DWFUNDERLAY", "DGNUNDERLAY", "OLE2FRAME", "PLANESURFACE"]
LATER += ["ARC_DIMENSION", "LARGE_RADIAL_DIMENSION"]
LATER += ["EXTRUDEDSURFACE", "LOFTEDSURFACE", "REVOLVEDSURFACE", "SWEPTSURFACE"]
LATER += ["ACAD_PROXY_ENTITY"]
REFUSED = [(kind, v) for kind in IN_R12 for v in VERSIONS]
REFUSED += [(kind, v) for kind in LATER for v in SINCE_R2000]


@pytest.mark.parametrize(("kind", "version"), REFUSED)
def test_every_other_type_is_refused_by_name_handle_and_layer(kind, version):
    document = new(version)
    frame(document.modelspace())
    entity = document.modelspace().new_entity(kind, {"layer": "SCRAP"})
    said = f"{kind} #{entity.dxf.handle} on layer SCRAP cannot be cut"
    with pytest.raises(ValueError, match=f"^{said}"):
        drawing_of(document, MILLIMETRES)


def test_every_graphic_type_of_the_library_is_in_a_test_of_this_page():
    """Of ezdxf, which knows those of R12 to R2018: vertices and ends belong to what has them."""
    graphic = {n for n, kind in factory.ENTITY_CLASSES.items() if issubclass(kind, DXFGraphic)}
    aliases = {"MLEADER", "PDFREFERENCE"}  # of MULTILEADER, and of an underlay's definition
    elsewhere = {"INSERT", "IMAGE", "ATTRIB", "VERTEX", "SEQEND"}
    assert graphic - aliases - elsewhere <= {*READERS, *IN_R12, *LATER}


def attribute(document):
    document.blocks.new("B").add_circle((0, 0), 2.0)
    insert = document.modelspace().add_blockref("B", (20, 20))
    insert.add_attrib("TAG", "M6", (20, 20), dxfattribs={"layer": "NOTES"})
    return f"ATTRIB of INSERT #{insert.dxf.handle} on layer NOTES"


def image(document):
    picture = document.add_image_def("logo.png", (8, 8))
    document.modelspace().add_image(picture, (0, 0), (8, 8))
    return "IMAGE #.* on layer 0"


def text_of_a_block(document):
    document.blocks.new("B").add_text("8 x", dxfattribs={"layer": "NOTES"})
    insert = document.modelspace().add_blockref("B", (20, 20))
    return f"TEXT of INSERT #{insert.dxf.handle} on layer NOTES"


@pytest.mark.parametrize("draw", [attribute, image, text_of_a_block])
def test_what_comes_with_a_block_or_a_file_is_refused_by_name(draw):
    document = new()
    frame(document.modelspace())
    said = draw(document)
    with pytest.raises(ValueError, match=f"^{said} cannot be cut"):
        drawing_of(document, MILLIMETRES)


@pytest.mark.parametrize("kind", ["ACAD_TABLE", "TYPE_OF_TOMORROW"])
def test_a_type_that_no_library_knows_is_refused_as_well(kind, tmp_path):
    document = new("R2018")
    frame(document.modelspace())
    file = save(document, tmp_path)
    begin, rest = file.read_text().split("ENTITIES\n", 1)
    raw = f"  0\n{kind}\n  5\nABCD\n330\n1F\n100\nAcDbEntity\n  8\n0\n"
    file.write_text(f"{begin}ENTITIES\n{raw}{rest}")
    with pytest.raises(ValueError, match=rf"^part.dxf: {kind} #ABCD on layer 0 cannot be cut"):
        read_part(file)
