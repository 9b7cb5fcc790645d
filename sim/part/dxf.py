"""Drawings in DXF, R12 to 2018, read with ezdxf: a chain for each entity that can be cut."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
from ezdxf import transform, units
from ezdxf.math import Matrix44

from armside.arrays import Array

from .arcs import Chain, arc, ellipse, fitted, line, place, polyline
from .drawing import Drawing, DrawnChain, Reading, Unit
from .expansion import check_expansion, check_points

FLAT = 1e-6
"""Largest difference of height within an entity, and of a normal from +-z, relative to 1."""
LINES = 2_000_000
"""Most lines of a file, two for each value: those of 100000 entities."""
IMPERIAL = (units.IN, units.FT, units.YD, units.MI)
_LAYER_0, MODEL = "0", "*Model_Space"
INVISIBLE = "what is invisible is not cut"


class NotFlatError(ValueError):
    def __init__(self, label: str = "it") -> None:
        super().__init__(f"{label} is not drawn in the x-y plane")


def _line(entity: Any, scale: float) -> Chain:
    start, end = entity.dxf.start, entity.dxf.end
    _level([start.z, end.z])
    return line(_point(start, scale), _point(end, scale))


def _arc(entity: Any, scale: float) -> Chain:
    centre, radius = _point(entity.dxf.center, scale), scale * entity.dxf.radius
    if not radius > 0.0:
        raise ValueError(f"its radius is {entity.dxf.radius:g}, at {place(centre)}")
    whole = entity.dxftype() == "CIRCLE"
    ends = (0.0, 0.0) if whole else (entity.dxf.start_angle, entity.dxf.end_angle)
    first, last = np.radians(ends)
    return _seen_from_above(entity, arc(centre, radius, first, _turn(first, last)))


def _turn(first: float, last: float) -> float:
    """Counter-clockwise from one angle to another [rad]; a whole turn where they are one."""
    angle = np.mod(last - first, 2.0 * np.pi)
    return angle if angle > 1e-9 else 2.0 * np.pi


def _ellipse(entity: Any, scale: float) -> Chain:
    tool = entity.construction_tool()
    for axis in (tool.major_axis, tool.minor_axis):
        if abs(axis.z) > FLAT * axis.magnitude:
            raise NotFlatError
    major, minor = _point(tool.major_axis, scale), _point(tool.minor_axis, scale)
    span = _turn(tool.start_param, tool.end_param)
    at = ellipse(_point(tool.center, scale), major, minor)
    return _exactly_closed(fitted(at, tool.start_param + span * np.linspace(0.0, 1.0, 5)))


def _spline(entity: Any, scale: float) -> Chain:
    tool = entity.construction_tool()
    _level([point.z for point in tool.control_points])
    knots = np.array(tool.knots())
    lower, upper = knots[tool.order - 1], knots[-tool.order]
    inside = knots[(knots >= lower) & (knots <= upper)]

    def at(t: float) -> tuple[Array, Array]:
        point, along = next(iter(tool.derivatives([min(max(t, lower), upper)], 1)))
        return _point(point, scale), _point(along, scale)

    return _exactly_closed(fitted(at, np.unique(inside)))


def _polyline(entity: Any, scale: float) -> Chain:
    if not (entity.is_2d_polyline or entity.is_3d_polyline):
        raise ValueError("it is a mesh, not a curve")
    frame = 16  # vertex of the control frame of a smoothed polyline, not on the curve
    present = [v.dxf for v in entity.vertices if not v.dxf.flags & frame]
    _level([v.location.z for v in present])
    rows = [(v.location.x, v.location.y, v.get("bulge", 0.0)) for v in present]
    return _bulged(entity, rows, bool(entity.is_closed), scale)


def _bulged(entity: Any, rows: Any, closed: bool, scale: float) -> Chain:
    vertices = np.array(rows, dtype=np.float64).reshape(-1, 3)
    if closed and len(vertices) > 1:
        vertices = np.vstack([vertices, vertices[:1]])
    step = np.linalg.norm(np.diff(vertices[:, :2], axis=0), axis=1)
    # A last vertex on the first of a closed polyline, and doubled vertices, add no element.
    present = np.concatenate([[True], step > 0.0])
    if present.sum() < 2:
        at = f" at {place(scale * vertices[0, :2])}" if len(vertices) else ": it has no vertex"
        raise ValueError(f"it has zero length{at}")
    check_points(len(vertices))
    chain = polyline(scale * vertices[present, :2], vertices[:-1, 2][step > 0.0])
    return _seen_from_above(entity, chain)


def _seen_from_above(entity: Any, chain: Chain) -> Chain:
    """The chain in world axes: one that is drawn with its normal along -z is mirrored."""
    x, y, z = np.array(entity.dxf.get("extrusion", (0.0, 0.0, 1.0)), dtype=np.float64)
    if abs(x) + abs(y) > FLAT * abs(z):
        raise NotFlatError
    return chain if z > 0.0 else Chain(chain.points * [-1.0, 1.0], -chain.bulge)


def _check_normal(entity: Any, label: str) -> None:
    if entity.dxf.is_supported("extrusion") and not np.any(entity.dxf.get("extrusion", 1.0)):
        raise NotFlatError(label)


def _point(vector: Any, scale: float) -> Array:
    return scale * np.array([vector.x, vector.y])


def _level(heights: list[float]) -> None:
    if np.ptp(heights) > FLAT * max(1.0, float(np.abs(heights).max())):
        raise NotFlatError


def _exactly_closed(chain: Chain) -> Chain:
    """The chain with its last point on the first, where they differ by rounding."""
    return chain.ending_at_start(1e-9 * chain.length)


READERS: Mapping[str, Callable[[Any, float], Chain]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _arc,
    "ELLIPSE": _ellipse,
    "SPLINE": _spline,
    "LWPOLYLINE": lambda e, scale: _bulged(e, e.get_points("xyb"), bool(e.closed), scale),
    "POLYLINE": _polyline,
}
"""By type; every other type is refused by name. INSERT is taken apart before."""


def read_dxf(file: Path, reading: Reading) -> Drawing:
    """Entities of the model space on the chosen layers.

    Raises ValueError for an entity that cannot be cut, by type, handle and layer, for a unit in
    doubt, and for a file that is no drawing; OSError if it cannot be read.
    """
    return drawing_of(opened(file), reading)


def opened(file: Path) -> Any:
    """Document of ezdxf. Raises as `read_dxf`."""
    if (lines := file.read_bytes().count(b"\n")) > LINES:
        raise ValueError(f"it has {lines} lines, more than {LINES}")
    try:
        return ezdxf.readfile(file)  # pyright: ignore[reportPrivateImportUsage]
    except OSError as error:
        if error.errno is not None:
            raise
        raise ValueError("this is no DXF drawing") from error  # as ezdxf says it
    except Exception as error:  # a damaged file fails anywhere in the parser
        raise ValueError(f"this is no DXF drawing: {error}") from error


def drawing_of(document: Any, reading: Reading) -> Drawing:
    """As `read_dxf`, of a document of ezdxf."""
    scale = _metres(document, reading.unit)
    reading.check_layers([layer.dxf.name for layer in document.layers])
    check_expansion(MODEL, lambda name: _contents(document, name), "block {!r}".format)
    left_out: Counter[str] = Counter()
    found: list[DrawnChain] = []
    for entity, layer, name, gone in _entities(document, document.modelspace()):
        if gone == INVISIBLE or not reading.chooses(layer, not gone and _shown(document, layer)):
            left_out[gone or f"layer {layer} is not cut"] += 1
        else:
            found.append(_read(entity, layer, name, scale))
    notes = [
        f"{what}: {n} {'entity' if n == 1 else 'entities'}" for what, n in sorted(left_out.items())
    ]
    paper = (e for view in document.layouts if view.is_any_paperspace for e in view)
    if n := sum(e.dxftype() != "VIEWPORT" for e in paper):
        notes.append(f"{n} entities of paper space are not cut")
    return Drawing(tuple(found), tuple(notes))


def _read(entity: Any, layer: str, name: str, scale: float) -> DrawnChain:
    reader = READERS.get(entity.dxftype())
    label = f"{name} on layer {layer}"
    if reader is None:
        raise ValueError(f"{label} cannot be cut; choose the layers to cut, or remove it")
    _check_normal(entity, label)
    try:
        chain = reader(entity, scale)
    except NotFlatError as error:
        raise NotFlatError(label) from error
    except ValueError as error:
        raise ValueError(f"{label}: {error}") from error
    if not np.isfinite(chain.points).all():
        raise ValueError(f"{label} has coordinates that are not finite")
    return DrawnChain(chain, name, layer)


def _contents(document: Any, name: str) -> Iterator[tuple[int, str]]:
    """Blocks in a block, with their numbers; entities as blocks of no name."""
    entities = list(document.blocks.get(name, ()))
    inserts = [entity for entity in entities if entity.dxftype() == "INSERT"]
    yield from ((insert.mcount, insert.dxf.name.lower()) for insert in inserts)
    if more := len(entities) - len(inserts):
        yield more, ""


def _entities(
    document: Any,
    container: Any,
    layer: str = "",
    name: str = "",
    gone: str = "",
    matrix: Matrix44 | None = None,
) -> Iterator[tuple[Any, str, str, str]]:
    """Entities, their layers, names and what hides them, blocks taken apart.

    Layer 0 of a block is its insert's. gone: what hides all in the container. matrix: from it to
    the world, whole: inserts that ezdxf transforms by themselves cannot be skewed.
    """
    for entity in container:
        own = _layer_of(entity)
        effective = layer if layer and own == _LAYER_0 else own
        label = f"{entity.dxftype()}{name or f' #{entity.dxf.handle}'}"
        hidden = gone
        if entity.dxf.is_supported("invisible") and entity.dxf.get("invisible", 0):
            hidden = INVISIBLE
        if entity.dxftype() != "INSERT":
            moves = None if hidden else matrix
            for each in _moved(entity, moves, f"{label} on layer {effective}"):
                kind = f"{each.dxftype()}{name}" if name else label
                yield each, effective, kind, hidden
            continue
        if not hidden and not _shown(document, effective, "is_frozen"):
            hidden = f"layer {effective} is not cut"
        within = name or f" of INSERT #{entity.dxf.handle}"
        for a in entity.attribs:
            its = effective if a.dxf.layer == _LAYER_0 else a.dxf.layer
            yield a, its, f"ATTRIB{within}", hidden
        for each in entity.multi_insert() if entity.mcount > 1 else [entity]:
            parts, own = _parts(each, effective, within), each.matrix44()
            whole = own if matrix is None else own * matrix
            yield from _entities(document, parts, effective, within, hidden, whole)


def _layer_of(entity: Any) -> str:
    """Layer of an entity, of types that ezdxf does not know as well."""
    if entity.dxf.is_supported("layer"):
        return entity.dxf.get("layer", _LAYER_0)
    tags = entity.xtags
    own = tags.get_subclass("AcDbEntity") if tags.has_subclass("AcDbEntity") else tags.noclass
    return str(own.get_first_value(8, _LAYER_0))


def _parts(insert: Any, layer: str, within: str) -> list[Any]:
    block, label = insert.block(), f"block {insert.dxf.name!r}{within} on layer {layer}"
    if block is None or block.block.is_xref:
        what = "is not in the file" if block is None else "is another file (XREF)"
        raise ValueError(f"{label} {what}")
    _check_normal(insert, label)
    return list(block)


def _moved(entity: Any, matrix: Matrix44 | None, label: str) -> list[Any]:
    """Copies of an entity in the world; itself where it cannot be cut."""
    if matrix is None or entity.dxftype() not in READERS:
        return [entity]
    _check_normal(entity, label)
    log, copies = transform.copies([entity], matrix)
    if not copies or len(log):
        raise ValueError(f"{label} cannot be moved with its block; take the block apart")
    return copies


def _shown(document: Any, layer: str, *hidden_if: str) -> bool:
    """Whether a layer is neither off nor frozen, or not what is asked."""
    if layer not in document.layers:
        return True
    found = document.layers.get(layer)
    return not any(getattr(found, ask)() for ask in hidden_if or ("is_off", "is_frozen"))


def _metres(document: Any, chosen: Unit | None) -> float:
    """Metres per unit of a drawing. ValueError where millimetres and inches are in doubt."""
    if chosen is not None:
        return chosen.metres
    own, system = document.units, document.header.get("$MEASUREMENT", None)
    if not own:
        raise ValueError("its unit is not stated ($INSUNITS): say --units mm or --units inch")
    try:
        scale = units.conversion_factor(own, units.M)  # pyright: ignore[reportArgumentType]
    except (TypeError, ValueError, LookupError):
        raise ValueError(f"its unit is in doubt: $INSUNITS is {own}; say --units mm") from None
    stated = units.unit_name(own)
    if own in (units.MM, units.IN) and system is not None and (own in IMPERIAL) == bool(system):
        other = "metric" if system else "imperial"
        raise ValueError(
            f"its unit is in doubt: $INSUNITS says {stated}, $MEASUREMENT says {other}; say "
            "--units mm or --units inch"
        )
    return float(scale)
