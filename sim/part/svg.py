"""Drawings in SVG, read with svgelements.

A layer is a group that Inkscape marks as one, by its label; elsewhere the outermost group, by its
id. y points down in SVG and up here.
"""

import re
from collections import Counter
from collections.abc import Iterator
from math import comb
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import svgelements

from armside.arrays import Array

from .arcs import Chain, arc, fitted, joined, line, place
from .drawing import Drawing, DrawnEntity, Reading, Unit

ROUND = 1e-9
"""Relative difference of half axes and of their angle from 90 deg in a circle."""
PAGE = 1e-3
"""Relative difference from the page within which a filled rectangle is its background."""
UNITS = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6, "q": 0.25e-3}
"""[m], of the units that are lengths; px is one of a screen."""
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
SVG = "{http://www.w3.org/2000/svg}"
EDITORS = (INKSCAPE, "{http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd}")
"""Namespaces of what editors keep beside a drawing."""
SHAPES = {"path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "use"}
GROUPS = {"svg", "g", "a", "switch", "symbol"}
SILENT = {"defs", "title", "desc", "metadata", "style", "script"}
"""Tags that draw nothing where they stand."""
CLIPPED = "clipped shapes cannot be cut; release the clip, or draw without it"


def chains(path: Any, scale: float) -> Iterator[Chain]:
    """A chain [m] for each part of a path; `scale` in metres per pixel."""
    pieces: list[Chain] = []
    for segment in path:
        if isinstance(segment, svgelements.Move):
            if pieces:
                yield _whole(pieces)
            pieces = []
            continue
        chain = _chain(segment, scale)
        if chain is not None:
            pieces.append(_from_end(pieces, chain))
        if isinstance(segment, svgelements.Close):
            if pieces:
                yield _whole(pieces)
            pieces = []
    if pieces:
        yield _whole(pieces)


def _chain(segment: Any, scale: float) -> Chain | None:
    """One segment; None for one of zero length, as drawing programs leave them."""
    start, end = _point(segment.start, scale), _point(segment.end, scale)
    if isinstance(segment, (svgelements.Line, svgelements.Close)):
        return None if np.array_equal(start, end) else line(start, end)
    if isinstance(segment, svgelements.Arc):
        return _arc(segment, scale)
    if isinstance(segment, svgelements.QuadraticBezier):
        control = _point(segment.control, scale)
        return _bezier(np.array([start, control, end]))
    if isinstance(segment, svgelements.CubicBezier):
        controls = [_point(segment.control1, scale), _point(segment.control2, scale)]
        return _bezier(np.array([start, *controls, end]))
    raise ValueError(f"{type(segment).__name__} is not known here")


def _bezier(control: Array) -> Chain | None:
    if not np.ptp(control, axis=0).any():
        return None
    n = len(control) - 1
    first, step = np.poly1d([1.0, 0.0]), np.poly1d([-1.0, 1.0])
    basis = [comb(n, k) * first**k * step ** (n - k) for k in range(n + 1)]
    slopes = [polynomial.deriv() for polynomial in basis]

    def at(t: float) -> tuple[Array, Array]:
        return (
            np.array([b(t) for b in basis]) @ control,
            np.array([b(t) for b in slopes]) @ control,
        )

    return fitted(at, [0.0, 1.0])


def _arc(segment: Any, scale: float) -> Chain | None:
    centre = _point(segment.center, scale)
    first = _point(segment.prx, scale) - centre
    second = _point(segment.pry, scale) - centre
    begin, sweep = float(segment.get_start_t()), float(segment.sweep)
    a, b = np.linalg.norm(first), np.linalg.norm(second)
    if sweep == 0.0 or a * b == 0.0:
        return None
    if abs(a - b) < ROUND * a and abs(first @ second) < ROUND * a * b:
        turn = np.sign(first[0] * second[1] - first[1] * second[0])
        angle = np.arctan2(first[1], first[0]) + turn * begin
        return arc(centre, float(a), float(angle), float(turn * sweep))

    def at(t: float) -> tuple[Array, Array]:
        direction = np.sign(sweep) * (np.cos(t) * second - np.sin(t) * first)
        return centre + np.cos(t) * first + np.sin(t) * second, direction

    parts = max(1, int(np.ceil(abs(sweep) / (np.pi / 2))))
    return fitted(at, (begin + sweep * np.linspace(0.0, 1.0, parts + 1)))


def _from_end(pieces: list[Chain], chain: Chain) -> Chain:
    """The chain from the exact end of the one before."""
    if not pieces:
        return chain
    return Chain(np.vstack([pieces[-1].points[-1:], chain.points[1:]]), chain.bulge)


def _whole(pieces: list[Chain]) -> Chain:
    """Pieces in one; its end is exactly its start where they differ by rounding."""
    whole = joined(pieces)
    first, last = whole.points[0], whole.points[-1]
    near = np.linalg.norm(last - first) < 1e-9 * max(1.0, float(np.abs(whole.points).max()))
    return whole.ending_at_start if near else whole


def _point(point: Any, scale: float) -> Array:
    return scale * np.array([float(point.x), -float(point.y)])


def invisible(shape: Any) -> bool:
    """Neither stroke nor fill; a shape whose fill is not stated is filled black."""
    values = shape.values
    if _number(values.get("opacity", 1.0)) == 0.0:
        return True
    return not _stroked(shape) and "fill" in values and not _painted(shape.fill)


def is_background(shape: Any, width: float, height: float) -> bool:
    """A filled rectangle without stroke that covers the page [pixels]."""
    if _stroked(shape) or invisible(shape):
        return False
    box = shape.bbox()
    if box is None:
        return False
    page, size = (0.0, 0.0, width, height), max(width, height)
    covers = all(abs(a - b) <= PAGE * size for a, b in zip(box, page, strict=True))
    return covers and _is_box(shape, box, PAGE * size)


def _is_box(shape: Any, box: tuple[float, float, float, float], near: float) -> bool:
    """All points of a shape of lines are corners of its box."""
    points = [segment.end for segment in shape.segments() if segment.end is not None]
    if any(type(segment).__name__ not in ("Move", "Line", "Close") for segment in shape.segments()):
        return False
    return all(
        min(abs(point.x - box[0]), abs(point.x - box[2])) <= near
        and min(abs(point.y - box[1]), abs(point.y - box[3])) <= near
        for point in points
    )


def _stroked(shape: Any) -> bool:
    return "stroke" in shape.values and _painted(shape.stroke)


def _painted(color: Any) -> bool:
    return color is not None and color.value is not None and bool(color.alpha)


def _number(text: Any) -> float:
    try:
        return float(text)
    except (TypeError, ValueError):
        return 1.0


def read_svg(file: Path, reading: Reading) -> Drawing:
    """Shapes on the chosen layers.

    Raises ValueError for text, images and whatever else cannot be cut, by tag, id and layer, for a
    unit in doubt, and for a file that is no drawing; OSError if it cannot be read.
    """
    try:
        root = ElementTree.parse(file).getroot()
        drawing: Any = svgelements.SVG.parse(str(file), reify=True, ppi=96)
    except (ElementTree.ParseError, ValueError, UnicodeDecodeError) as error:
        raise ValueError(f"this is no SVG drawing: {error}") from error
    if root.tag.removeprefix(SVG) != "svg":
        raise ValueError(f"this is no SVG drawing: its root is {root.tag!r}")
    scale = _metres_per_pixel(root, drawing, reading.unit)
    left_out: Counter[str] = Counter()
    layers = _check(root, reading, left_out)
    reading.check_layers(sorted(layers - {""}))
    found, backgrounds, page = [], [], (float(drawing.width), float(drawing.height))
    of_tag: Counter[str] = Counter()
    for shape, layer in _shapes(drawing, ""):
        name = _name(shape, of_tag)
        if not reading.chooses(layer):
            continue
        if invisible(shape):
            left_out["elements without stroke and fill"] += 1
        elif is_background(shape, *page):
            backgrounds.append(f"{name} fills the page: its background, which is not cut")
        else:
            found += _drawn(shape, name, layer, scale)
    notes = [f"{what} that are not cut: {n}" for what, n in sorted(left_out.items())]
    return Drawing(tuple(found), (*notes, *backgrounds))


def _drawn(shape: Any, name: str, layer: str, scale: float) -> list[DrawnEntity]:
    try:
        path = svgelements.Path(shape).reify()
        found = [DrawnEntity(chain, name, layer) for chain in chains(path, scale)]
        if not found and (ends := [segment.end for segment in path if segment.end is not None]):
            at = place(scale * np.array([ends[0].x, -ends[0].y]))
            raise ValueError(f"it has zero length at {at}")
    except ValueError as error:
        raise ValueError(f"{name} on layer {layer or '(none)'}: {error}") from error
    return found


def _name(shape: Any, of_tag: Counter[str]) -> str:
    """Tag and id, or the number among the shapes of its tag, which are counted."""
    own, tag = shape.values.get("attributes", {}), shape.values.get("tag", "path")
    of_tag[tag] += 1
    known = own.get("id") or shape.id
    return f"{tag} #{known}" if known else f"{tag} {of_tag[tag]} (without id)"


def _shapes(group: Any, layer: str) -> Iterator[tuple[Any, str]]:
    for element in group:
        own = element.values.get("attributes", {})
        if isinstance(element, svgelements.Group):
            yield from _shapes(element, _layer(own, layer))
        elif isinstance(element, svgelements.Shape):
            yield element, layer


def _layer(attributes: Any, outer: str) -> str:
    if attributes.get(f"{INKSCAPE}groupmode") == "layer":
        return attributes.get(f"{INKSCAPE}label") or attributes.get("id") or outer
    return outer or attributes.get("id") or ""


def _check(root: Any, reading: Reading, left_out: Counter[str]) -> set[str]:
    """Layers of a file; ValueError for what cannot be cut, and a count of what is not cut."""
    layers: set[str] = set()
    for element, layer, hidden in _elements(root, "", False):
        tag = element.tag.removeprefix(SVG)
        layers.add(layer)
        known = f"#{element.get('id')}" if element.get("id") else "(without id)"
        label = f"{tag} {known} on layer {layer or '(none)'}"
        if tag.startswith("{"):  # which no viewer draws
            if not tag.startswith(EDITORS):
                left_out[f"elements of namespace {tag[1:].split('}')[0]}"] += 1
        elif not reading.chooses(layer):
            left_out[f"layer {layer or '(none)'}: elements"] += 1
        elif hidden:
            left_out["hidden elements"] += 1
        elif tag not in SHAPES:
            raise ValueError(f"{label} cannot be cut; choose the layers to cut, or remove it")
        elif clip := [name for name in ("clip-path", "mask") if _property(element, name)]:
            raise ValueError(f"{label} has a {clip[0]}: {CLIPPED}")
    return layers


def _elements(parent: Any, layer: str, hidden: bool) -> Iterator[tuple[Any, str, bool]]:
    for element in parent:
        if not isinstance(element.tag, str):  # a comment
            continue
        tag = element.tag.removeprefix(SVG)
        gone = hidden or _property(element, "display") == "none"
        gone = gone or _property(element, "visibility") == "hidden"
        if tag in GROUPS - {"symbol"}:
            if clip := [name for name in ("clip-path", "mask") if _property(element, name)]:
                raise ValueError(f"group #{element.get('id')} has a {clip[0]}: {CLIPPED}")
            yield from _elements(element, _layer(element.attrib, layer), gone)
        elif tag not in SILENT | {"symbol"}:
            yield element, layer, gone


def _property(element: Any, name: str) -> str:
    """A presentation attribute or its value in the element's style."""
    style = re.search(rf"(?:^|;)\s*{name}\s*:\s*([^;]+)", element.get("style", ""))
    value = style.group(1).strip() if style else element.get(name, "")
    return "" if name in ("clip-path", "mask") and value == "none" else value


def _metres_per_pixel(root: Any, drawing: Any, chosen: Unit | None) -> float:
    if chosen is not None:
        return chosen.metres / _pixels_per_unit(drawing)
    stated = root.get("width", "").strip()
    found = re.fullmatch(r"([-+.\deE]+?)\s*([A-Za-z]+)", stated)
    unit = found.group(2).lower() if found else ""
    if not found or unit not in UNITS:
        raise ValueError(
            f"its unit is in doubt: its width is {stated or 'not stated'}, which is no length in "
            "mm, cm or in; say --units mm or --units inch"
        )
    try:
        width = float(found.group(1)) * UNITS[unit]
    except ValueError as error:
        raise ValueError(f"its width {stated!r} is no length") from error
    if not width > 0.0:
        raise ValueError(f"its width is {stated}")
    return width / float(drawing.width)


def _pixels_per_unit(drawing: Any) -> float:
    box = drawing.viewbox
    if box is None or not box.width or not box.height:
        return 1.0
    return min(float(drawing.width) / box.width, float(drawing.height) / box.height)
