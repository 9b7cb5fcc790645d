"""Drawings in SVG, read with svgelements.

A layer is a group that Inkscape marks as one, by its label; elsewhere the outermost group, by its
id. y points down in SVG and up here.
"""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import svgelements

from .chain import place
from .drawn import Drawing, Drawn, Reading, Unit
from .svg_paint import invisible, is_background
from .svg_shapes import chains

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


def _drawn(shape: Any, name: str, layer: str, scale: float) -> list[Drawn]:
    try:
        path = svgelements.Path(shape).reify()
        found = [Drawn(chain, name, layer) for chain in chains(path, scale)]
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
    """Layer of what is inside a group."""
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
        said = f"{tag} {known} on layer {layer or '(none)'}"
        if tag.startswith("{"):  # which no viewer draws
            if not tag.startswith(EDITORS):
                left_out[f"elements of namespace {tag[1:].split('}')[0]}"] += 1
        elif not reading.chooses(layer):
            left_out[f"layer {layer or '(none)'}: elements"] += 1
        elif hidden:
            left_out["hidden elements"] += 1
        elif tag not in SHAPES:
            raise ValueError(f"{said} cannot be cut; choose the layers to cut, or remove it")
        elif clip := [name for name in ("clip-path", "mask") if _property(element, name)]:
            raise ValueError(f"{said} has a {clip[0]}: {CLIPPED}")
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
    said = root.get("width", "").strip()
    found = re.fullmatch(r"([-+.\deE]+?)\s*([A-Za-z]+)", said)
    unit = found.group(2).lower() if found else ""
    if not found or unit not in UNITS:
        raise ValueError(
            f"its unit is in doubt: its width is {said or 'not stated'}, which is no length in mm, "
            "cm or in; say --units mm or --units inch"
        )
    try:
        width = float(found.group(1)) * UNITS[unit]
    except ValueError as error:
        raise ValueError(f"its width {said!r} is no length") from error
    if not width > 0.0:
        raise ValueError(f"its width is {said}")
    return width / float(drawing.width)


def _pixels_per_unit(drawing: Any) -> float:
    box = drawing.viewbox
    if box is None or not box.width or not box.height:
        return 1.0
    return min(float(drawing.width) / box.width, float(drawing.height) / box.height)
