"""DXF in doubt: bombs, circles of blocks, what does not show, normals and units that are none."""

from time import process_time

import pytest
from ezdxf import units

from armside.sim.part.drawing import Reading
from armside.sim.part.dxf import read_dxf
from armside.sim.part.part import read_part

from .drawings import frame, new, save


def read(document, folder, **reading):
    return read_dxf(save(document, folder), Reading(**reading))


def nested(document):
    """A million circles in six levels of ten inserts."""
    document.blocks.new("B0").add_circle((0, 0), 1.0)
    for i in range(6):
        block = document.blocks.new(f"B{i + 1}")
        for k in range(10):
            block.add_blockref(f"B{i}", (3 * k, i))
    document.modelspace().add_blockref("B6", (0, 0))


def rows(document):
    document.blocks.new("B").add_circle((0, 0), 1.0)
    grid = {"row_count": 1000, "column_count": 1000, "row_spacing": 3, "column_spacing": 3}
    document.modelspace().add_blockref("B", (0, 0), dxfattribs=grid)


def deep(document):
    for i in range(300):
        document.blocks.new(f"B{i}").add_blockref(f"B{i + 1}", (0, 0))
    document.blocks.new("B300").add_circle((0, 0), 1.0)
    document.modelspace().add_blockref("B0", (0, 0))


def circular(document):
    for a, b in ("AB", "BC", "CA"):
        document.blocks.new(a).add_blockref(b, (0, 0))
    document.modelspace().add_blockref("A", (0, 0))


BOMBS = {
    "nested inserts": (nested, r"block 'b\d' has \d+ elements, more than 100000"),
    "rows and columns": (rows, r"block '\*Model_Space' has 2000001 elements, more than 100000"),
    "blocks too deep": (deep, r"block 'b\d+' is nested more than 100 levels deep"),
    "blocks in a circle": (circular, r"block 'a' contains itself"),
}


@pytest.mark.parametrize("case", BOMBS)
def test_a_bomb_in_dxf_is_refused_by_its_count(case, tmp_path):
    """Within 5 s, asks the issue; it takes less than one."""
    draw, said = BOMBS[case]
    document = new()
    draw(document)
    file, begun = save(document, tmp_path), process_time()
    with pytest.raises(ValueError, match=rf"^part\.dxf: {said}"):
        read_part(file)
    assert process_time() - begun < 5.0


def test_an_invisible_entity_is_noted_as_such_and_its_layer_is_cut(tmp_path):
    document = new()
    space = document.modelspace()
    frame(space)
    space.add_circle((20, 20), 5.0, dxfattribs={"invisible": 1})
    for chosen in ((), ("0",)):
        part = read_part(save(document, tmp_path), Reading(layers=chosen))
        assert len(part.contours) == 1
        assert part.notes == ("what is invisible is not cut: 1 entity",)


def test_an_insert_that_is_invisible_or_frozen_hides_all_of_its_block(tmp_path):
    document = new()
    document.layers.add("COLD").freeze()
    document.layers.add("CUT")
    block = document.blocks.new("B")
    block.add_circle((20, 20), 5.0, dxfattribs={"layer": "CUT"})
    space = document.modelspace()
    space.add_blockref("B", (0, 0), dxfattribs={"invisible": 1})
    space.add_blockref("B", (20, 0), dxfattribs={"layer": "COLD"})
    drawing = read(document, tmp_path)
    assert not drawing.entities
    wanted = ("layer COLD is not cut: 1 entity", "what is invisible is not cut: 1 entity")
    assert drawing.notes == wanted


@pytest.mark.parametrize("kind", ["CIRCLE", "ARC", "LWPOLYLINE", "ELLIPSE", "INSERT"])
def test_a_normal_of_no_length_is_refused_by_name(kind, tmp_path):
    document, down = new(), {"extrusion": (0, 0, -1)}
    document.blocks.new("B").add_circle((1, 0), 2.0)
    space = document.modelspace()
    {
        "CIRCLE": lambda: space.add_circle((20, 20), 5.0, dxfattribs=down),
        "ARC": lambda: space.add_arc((20, 20), 5.0, 0, 90, dxfattribs=down),
        "LWPOLYLINE": lambda: space.add_lwpolyline([(0, 0), (9, 0), (9, 9)], dxfattribs=down),
        "ELLIPSE": lambda: space.add_ellipse((20, 20), (5, 0), 0.5, dxfattribs=down),
        "INSERT": lambda: space.add_blockref("B", (20, 20), dxfattribs=down),
    }[kind]()
    file = save(document, tmp_path)
    before, normal = "210\n0.0\n220\n0.0\n230\n", "-1.0\n"
    assert file.read_text().count(before + normal) == 1
    file.write_text(file.read_text().replace(before + normal, before + "0.0\n"))
    with pytest.raises(ValueError, match=rf"{kind} #\w+ on layer 0.* not drawn in the x-y plane"):
        read_dxf(file, Reading())


def test_a_polyline_of_a_million_points_is_refused_before_it_is_parsed(tmp_path):
    file = save(new(), tmp_path)
    begin, rest = file.read_text().split("ENTITIES\n", 1)
    points = " 10\n1.0\n 20\n2.0\n" * 1_000_000
    file.write_text(f"{begin}ENTITIES\n  0\nLWPOLYLINE\n  8\n0\n{points}{rest}")
    begun = process_time()
    with pytest.raises(ValueError, match=r"^part.dxf: it has \d+ lines, more than 2000000"):
        read_part(file)
    assert process_time() - begun < 5.0


@pytest.mark.parametrize("unit", [-4, 99])
def test_a_unit_that_is_none_is_named_with_the_file(unit, tmp_path):
    document = new()
    frame(document.modelspace())
    file = save(document, tmp_path)
    stated = f"$INSUNITS\n 70\n{units.MM}\n"
    assert stated in file.read_text()
    file.write_text(file.read_text().replace(stated, f"$INSUNITS\n 70\n{unit}\n"))
    with pytest.raises(ValueError, match=rf"^part\.dxf: its unit .*\$INSUNITS is {unit}; say"):
        read_part(file)
