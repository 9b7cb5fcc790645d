"""Drawings in SVG.

A resolver of ours (`svg_tree`) says which shapes show and where, with tinycss2 and cssselect2 for
styles and svgelements for the maths of paths: picosvg drops what is to be named and makes cubics of
arcs, resvg gives pixels alone, svgelements places symbols, hidden and restyled uses wrongly.
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

from .arcs import MM, Chain, arc, ellipse, fitted, joined, line, place
from .drawing import Drawing, DrawnChain, Reading, Unit
from .svg_shape import Size, fitted_in, length, shape, viewbox
from .svg_tree import INKSCAPE, SVG, UNSEEN, Clip, Document, Leaf

ROUND = 1e-9
"""Relative difference of half axes and of their angle from 90 deg in a circle."""
PAGE = 1e-3
"""Relative difference from the page within which a filled rectangle is its background."""
ZERO = 1e-12
"""Length of a segment that rounding leaves [m]."""
EDGE = 1e-6
"""Part of a viewport by which a shape at its edge may reach out of it."""
PIXEL = 0.0254 / 96
"""[m]"""
EDITORS = (INKSCAPE, "{http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd}")
"""Namespaces of what editors keep beside a drawing."""


def chains(path: Any, matrix: Array) -> Iterator[Chain]:
    """A chain [m] for each part of a path; `matrix` (3, 3) from its coordinates to metres."""
    pieces: list[Chain] = []
    for segment in [*path, svgelements.Move()]:
        moves = isinstance(segment, svgelements.Move)
        if not moves and (chain := _chain(segment, matrix)) is not None:
            pieces.append(chain)
        if pieces and (moves or isinstance(segment, svgelements.Close)):
            # One piece; its end is exactly its start where they differ by rounding.
            whole = joined(pieces)
            yield whole.ending_at_start(1e-9 * max(1.0, float(np.abs(whole.points).max())))
            pieces = []


def _chain(segment: Any, matrix: Array) -> Chain | None:
    """One segment; None for one of zero length, as drawing programs leave them."""
    ends = [segment.start, segment.end]
    match segment:
        case svgelements.Arc() if segment.rx * segment.ry != 0.0:
            return _arc(segment, matrix)
        case svgelements.QuadraticBezier():
            ends.insert(1, segment.control)
        case svgelements.CubicBezier():
            ends[1:1] = segment.control1, segment.control2
    points = np.array([_point(end, matrix) for end in ends])
    if len(points) > 2:
        return _bezier(points) if np.ptp(points, axis=0).any() else None
    return line(*points) if np.ptp(points, axis=0).max() >= ZERO else None


def _bezier(control: Array) -> Chain:
    n = len(control) - 1
    first, step = np.poly1d([1.0, 0.0]), np.poly1d([-1.0, 1.0])
    basis = [comb(n, k) * first**k * step ** (n - k) for k in range(n + 1)]
    slopes = [polynomial.deriv() for polynomial in basis]

    def of(polynomials: list[Any], t: float) -> Array:
        return np.array([b(t) for b in polynomials]) @ control

    return fitted(lambda t: (of(basis, t), of(slopes, t)), [0.0, 1.0])


def _arc(segment: Any, matrix: Array) -> Chain | None:
    centre = _point(segment.center, matrix)
    first = _point(segment.prx, matrix) - centre
    second = _point(segment.pry, matrix) - centre
    begin, sweep = float(segment.get_start_t()), float(segment.sweep)
    a, b = np.linalg.norm(first), np.linalg.norm(second)
    if sweep == 0.0:
        return None
    if abs(a - b) < ROUND * a and abs(first @ second) < ROUND * a * b:
        turn = np.sign(first[0] * second[1] - first[1] * second[0])
        angle = np.arctan2(first[1], first[0]) + turn * begin
        return arc(centre, float(a), float(angle), float(turn * sweep))

    parts = max(1, int(np.ceil(abs(sweep) / (np.pi / 2))))
    at = ellipse(centre, first, second, np.sign(sweep))
    return fitted(at, begin + sweep * np.linspace(0.0, 1.0, parts + 1))


def _point(point: Any, matrix: Array) -> Array:
    where = float(point.x), float(point.y)
    if not np.isfinite(where).all():
        raise ValueError("it has a coordinate that is no number")
    return matrix[:2, :2] @ where + matrix[:2, 2]


def read_svg(file: Path, reading: Reading) -> Drawing:
    """Shapes on the chosen layers.

    Raises ValueError for text, images and whatever else cannot be cut, by tag, id and layer, for a
    unit in doubt, and for a file that is no drawing; OSError if it cannot be read.
    """
    try:
        root = ElementTree.parse(file).getroot()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise ValueError(f"this is no SVG drawing: {error}") from error
    if root.tag.removeprefix(SVG) != "svg":
        raise ValueError(f"this is no SVG drawing: its root is {root.tag!r}")
    if b"<?xml-stylesheet" in file.read_bytes():
        raise ValueError("its styles are in another file; put them into the drawing")
    document, (page, metres) = Document(root), _page(root, reading.unit)
    paper: Clip = (np.diag([metres, -metres, 1.0]), page, "the page")
    left_out, layers, found, notes = Counter[str](), set[str](), list[DrawnChain](), list[str]()
    over = 0
    for leaf in document.leaves(page, metres):
        if leaf.tag.startswith("{"):  # which no viewer draws
            if not leaf.tag.startswith(EDITORS):
                left_out[f"elements of namespace {leaf.tag[1:].split('}')[0]}"] += 1
            continue
        layers.add(layer := leaf.at.layer)
        if not reading.chooses(layer):
            left_out[f"layer {layer or '(none)'}: elements"] += 1
        elif leaf.at.hidden:
            left_out[leaf.at.hidden] += 1
        elif not (drawn := _drawn(leaf, reading.join)):
            left_out[UNSEEN] += 1
        elif _is_background(leaf, drawn, paper):
            notes.append(f"{leaf.name} fills the page: its background, which is not cut")
        else:
            found += [DrawnChain(chain, leaf.name, layer) for chain in drawn]
            markers = [v for name, v in leaf.at.style.items() if name.startswith("marker")]
            left_out["markers"] += not {*markers} <= {"none", ""}
            over += any(_out_of(paper, chain) is not None for chain in drawn)
    reading.check_layers(sorted(layers - {""}))
    if over:
        notes.append(f"elements that reach over the page and are cut: {over}")
    counted = [f"{what} that are not cut: {n}" for what, n in sorted(left_out.items()) if n]
    return Drawing(tuple(found), (*counted, *notes))


def _drawn(leaf: Leaf, near: float) -> list[Chain]:
    """Chains of a shape, none of one that does not show. near: of ends that will be joined [m]."""
    label, at = f"{leaf.name} on layer {leaf.at.layer or '(none)'}", leaf.at
    if at.trouble:
        raise ValueError(f"{label}: {at.trouble}".replace(": it ", " ", 1))
    if not (leaf.filled or leaf.stroked):
        return []
    try:
        path = shape(leaf.tag, leaf.element, at.matrix, at.viewport)
        scale = np.linalg.svd(at.matrix[:2, :2], compute_uv=False)
        if scale[1] <= ROUND * scale[0]:
            raise ValueError("its transform leaves no area of it")
        found = list(chains(path, at.matrix))
        if not found and (ends := [segment.end for segment in path if segment.end is not None]):
            raise ValueError(f"it has zero length at {place(_point(ends[0], at.matrix))}")
        for chain in found:
            for clip in at.clips:
                if (out := _out_of(clip, chain)) is not None:
                    raise ValueError(f"{clip[2]} clips it at {place(out)}")
            gap = float(np.linalg.norm(chain.points[-1] - chain.points[0]))
            if not leaf.stroked and gap > near and len(chain.bulge) > 1:
                raise ValueError(
                    f"it is filled without a stroke, and open by {gap / MM:.3g} mm at "
                    f"{place(chain.points[0])}; close it"
                )
    except ValueError as error:
        raise ValueError(f"{label}: {error}") from error
    return [c for c in found if leaf.stroked or len(c.bulge) > 1]  # one element has no fill


def _out_of(clip: Clip, chain: Chain) -> Array | None:
    """A point of a chain outside of a viewport [m]."""
    points, size = chain.polygon(), np.array(clip[1])
    inside, near = _within(clip, points), EDGE * np.nanmax(size)
    out = ((inside < -near) | (inside > size + near)).any(axis=1)
    return points[int(out.argmax())] if out.any() else None


def _within(clip: Clip, points: Array) -> Array:
    """Points (N, 2) [m] in the coordinates of a viewport."""
    matrix = clip[0]
    return (points - matrix[:2, 2]) @ np.linalg.inv(matrix[:2, :2]).T


def _is_background(leaf: Leaf, drawn: list[Chain], paper: Clip) -> bool:
    """A filled rectangle without stroke that covers the page."""
    if leaf.stroked or len(drawn) != 1 or not drawn[0].closed or drawn[0].bulge.any():
        return False
    inside, size = _within(paper, drawn[0].points), paper[1]
    near = PAGE * max(size)
    corners = np.minimum(np.abs(inside), np.abs(inside - size)) <= near
    return bool(corners.all() and (np.abs(np.ptp(inside, axis=0) - size) <= 2 * near).all())


def _page(root: ElementTree.Element, chosen: Unit | None) -> tuple[Size, float]:
    """Width and height of the page [pixels], NaN where it has none, and metres of a pixel."""
    stated = root.get("width", "").strip()
    if chosen is None and not re.search(r"(mm|cm|in|pt|pc|q)$", stated.lower()):
        raise ValueError(
            f"its unit is in doubt: its width is {stated or 'not stated'}, which is no length in "
            "mm, cm or in; say --units mm or --units inch"
        )
    box = viewbox(root) or [0.0, 0.0, np.nan, np.nan]
    width, height = (
        None if "%" in root.get(name, "%") else length(root.attrib[name], name, (np.nan, np.nan))
        for name in ("width", "height")
    )
    if width is None:
        width = box[2] if height is None else height * box[2] / box[3]
    height = width * box[3] / box[2] if height is None else height
    if width <= 0.0 or height <= 0.0:
        raise ValueError(f"its width is {stated}, its height {root.get('height', 'not stated')}")
    if chosen is None:
        return (width, height), PIXEL
    scale = fitted_in(root, (width, height))[[0, 1], [0, 1]]
    if np.ptp(scale) > ROUND * scale[0]:
        raise ValueError("its viewBox is stretched: give its width and height in mm")
    return (width, height), chosen.metres / float(scale[0])
