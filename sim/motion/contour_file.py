"""Contours of files: corner points in TOML, or a drawing in DXF.

TOML, in millimetres around the centre of the cut; corners are rounded:

    corner = 1.5
    points = [[-10, -6], [10, -6], [10, 6], [0, 9], [-10, 6]]

A drawing has one closed polyline or circle, in its units (millimetres if it has none), around its
middle: its place in the drawing does not count. Anything else is refused, as it would not be cut.
Arcs of a polyline must join smoothly; corners of one of lines alone are rounded.
"""

import tomllib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .contour import ArcsAndLines, Circle, ClosedCurve, chord

Element = tuple[float, float]
"""Length [m], curvature [1/m]."""

MM = 1e-3
SMOOTH = 1e-4
"""Largest angle between elements that join smoothly [rad]."""
SHORTEST = 1e-9
"""Length below which an element is left out [m]."""
CORNER = 1.5
"""Default radius of corners [mm]."""


def rounded(points: ArrayLike, corner: float) -> ArcsAndLines:
    """Polygon through points (K, 2) [m], in either order, with rounded corners [m].

    Raises ValueError for fewer than three points, points that coincide, or a side too short for its
    corners.
    """
    p = np.asarray(points, dtype=np.float64)
    if p.ndim != 2 or p.shape[1] != 2 or len(p) < 3 or not np.isfinite(p).all():
        raise ValueError(f"points must be three or more pairs of numbers, got shape {p.shape}")
    if not corner > 0.0:
        raise ValueError(f"corner must be > 0 m, got {corner:g}")
    following = np.roll(p, -1, axis=0)
    if np.sum(p[:, 0] * following[:, 1] - following[:, 0] * p[:, 1]) < 0.0:  # clockwise
        p = p[::-1]
    side = np.roll(p, -1, axis=0) - p
    length = np.linalg.norm(side, axis=1)
    if length.min() < SHORTEST:
        raise ValueError(f"two points in a row are the same: {_in_mm(p[length.argmin()])} mm")
    heading = np.arctan2(side[:, 1], side[:, 0])
    turn = _wrapped(heading - np.roll(heading, 1))  # at the start of each side
    if np.abs(turn).max() > np.pi - 1e-6:
        place = _in_mm(p[np.abs(turn).argmax()])
        raise ValueError(f"the contour turns back on itself at {place} mm")
    cut = corner * np.tan(np.abs(turn) / 2.0)  # of both sides, for the arc at their corner
    straight = length - cut - np.roll(cut, -1)
    if straight.min() < 0.0:
        worst = int(straight.argmin())
        raise ValueError(
            f"the side from {_in_mm(p[worst])} mm is {length[worst] / MM:.4g} mm long, too short "
            f"for corners of {corner / MM:g} mm"
        )
    elements: list[Element] = []
    for line, bend in zip(straight.tolist(), np.roll(turn, -1).tolist(), strict=True):
        arc = (corner * abs(bend), float(np.copysign(1.0 / corner, bend)))
        elements += [(line, 0.0), arc]
    first = p[0] + cut[0] * side[0] / length[0]
    return _chain(first, float(heading[0]), elements)


def as_drawn(points: Array, bulge: Array) -> ArcsAndLines:
    """Closed polyline of points (K, 2) [m] with arcs.

    bulge: (K,), tangent of a quarter of the angle of the arc to the next point; 0 for a line.

    Raises ValueError for a corner.
    """
    angle = 4.0 * np.arctan(bulge)
    side = np.roll(points, -1, axis=0) - points
    distance = np.linalg.norm(side, axis=1)
    heading = np.arctan2(side[:, 1], side[:, 0]) - angle / 2.0
    kink = _wrapped(np.roll(heading, -1) - heading - angle)
    if np.sum(angle) + np.sum(kink) < 0.0:
        return as_drawn(points[::-1], -np.roll(bulge[::-1], -1))
    if (worst := np.abs(kink).max()) > SMOOTH:
        corner = points[(np.abs(kink).argmax() + 1) % len(points)]
        raise ValueError(
            f"there is a corner of {np.degrees(worst):.4g} deg at {_in_mm(corner)} mm; a polyline "
            f"with arcs must be smooth"
        )
    elements: list[Element] = []
    for length, a in zip(distance, angle, strict=True):
        if abs(a) < 1e-12:
            elements.append((float(length), 0.0))
        else:
            radius = length / (2.0 * np.sin(abs(a) / 2.0))
            elements.append((float(radius * abs(a)), float(np.copysign(1.0 / radius, a))))
    return _chain(points[0], float(heading[0]), elements)


def _chain(first: Array, heading: float, elements: Sequence[Element]) -> ArcsAndLines:
    """Chain that starts where it heads along +y on its right side, as all contours do."""
    present = [e for e in elements if e[0] > SHORTEST]
    place = np.array(first)
    best = (-np.inf, 0, 0.0, place)
    for i, (length, curvature) in enumerate(present):
        along = _where_north(heading, length, curvature)
        if along is not None:
            there = place + chord(along, curvature, heading)
            if there[0] > best[0] + SHORTEST:
                best = (float(there[0]), i, along, there)
        place = place + chord(length, curvature, heading)
        heading += length * curvature
    _, i, along, start = best
    length, curvature = present[i]
    begun = [(length - along, curvature), *present[i + 1 :], *present[:i], (along, curvature)]
    return ArcsAndLines(
        (float(start[0]), float(start[1])), tuple(e for e in begun if e[0] > SHORTEST)
    )


def _where_north(heading: float, length: float, curvature: float) -> float | None:
    """Length along an element to where it heads along +y, on a line to its middle; or None."""
    off = float(_wrapped(np.array(np.pi / 2.0 - heading)))
    if curvature == 0.0:
        return length / 2.0 if abs(off) < 1e-9 else None
    along = np.mod(off * np.sign(curvature), 2.0 * np.pi) / abs(curvature)
    return float(along) if along <= length else None


def _wrapped(angle: Array) -> Array:
    """Angle in (-pi, pi]."""
    return np.pi - np.mod(np.pi - angle, 2.0 * np.pi)


def _in_mm(point: Array) -> str:
    return f"({point[0] / MM:g}, {point[1] / MM:g})"


def read_drawing(file: Path, corner: float) -> ClosedCurve:
    """Contour of a drawing, its corners rounded with a radius [m]. Errors as in `read_contour`."""
    try:
        import ezdxf
        from ezdxf import units
    except ImportError as error:
        raise ImportError("drawings need the package ezdxf: pip install 'armside[dxf]'") from error
    try:
        drawing = ezdxf.readfile(file)  # pyright: ignore[reportPrivateImportUsage]
    except ezdxf.DXFError as error:  # pyright: ignore[reportPrivateImportUsage]
        raise ValueError(f"{file.name} is no drawing: {error}") from error
    scale = MM
    if drawing.units:
        scale = units.conversion_factor(drawing.units, units.M)  # pyright: ignore[reportArgumentType]
    elif drawing.header.get("$MEASUREMENT", 1) == 0:
        raise ValueError(f"{file.name} is imperial and has no unit; set its unit ($INSUNITS)")
    shape = _only_shape(file.name, list(drawing.modelspace()))
    try:
        if shape.dxftype() == "CIRCLE":
            return Circle(scale * shape.dxf.radius)
        vertices = np.array(shape.get_points("xyb"), dtype=np.float64)
        points, bulge = scale * vertices[:, :2], vertices[:, 2]
        points = points - 0.5 * (points.min(axis=0) + points.max(axis=0))
        if not bulge.any():
            return rounded(points, corner)
        return as_drawn(points, bulge)
    except ValueError as error:
        raise ValueError(f"{file.name}: {error}") from error


def _only_shape(name: str, entities: Sequence[Any]) -> Any:
    """The closed polyline or circle that is alone in a drawing, in its plane.

    Raises ValueError with a list of everything that would not be cut.
    """
    shapes = [e for e in entities if _kind(e) in ("CIRCLE", "closed LWPOLYLINE")]
    others = Counter(_kind(e) for e in entities if e not in shapes)
    listed = ", ".join(f"{count} {kind}" for kind, count in sorted(others.items()))
    if len(shapes) != 1:
        besides = f"; besides it has {listed}" if listed else ""
        found = f"{name} has {len(shapes)} closed polylines and circles"
        raise ValueError(f"{found}; a contour is exactly one{besides}")
    if others:
        found = f"{name} has more than its contour, which would not be cut: {listed}"
        raise ValueError(f"{found}; remove it, or join it to one closed polyline")
    if not np.allclose(shapes[0].dxf.extrusion, (0.0, 0.0, 1.0)):
        raise ValueError(f"{name}: the contour is not drawn in the x-y plane, seen from above")
    return shapes[0]


def _kind(entity: Any) -> str:
    """Type of an entity; of a polyline also whether it is closed."""
    kind = entity.dxftype()
    if kind == "LWPOLYLINE":
        kind = f"{'closed' if entity.closed else 'open'} {kind}"
    return kind


def read_contour(file: Path, corner: float | None = None) -> ClosedCurve:
    """Contour of a file.

    corner: radius of its corners [m]; None takes the file's own, or 1.5 mm.

    Raises:
        ValueError: a file that is not as above, or a contour that cannot be cut.
        OSError: the file cannot be read.
        ImportError: a drawing without the package ezdxf.
    """
    kind = file.suffix.lower()
    if kind == ".toml":
        return _from_toml(file, corner)
    if kind == ".dxf":
        return read_drawing(file, MM * CORNER if corner is None else corner)
    raise ValueError(f"{file.name}: a contour is a .toml or a .dxf file")


def _from_toml(file: Path, corner: float | None) -> ClosedCurve:
    try:
        data = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{file.name}: {error}") from error
    if unknown := [name for name in data if name not in ("points", "corner")]:
        raise ValueError(f"{file.name}: {unknown[0]} is not known here. Known: corner, points")
    if "points" not in data:
        raise ValueError(f"{file.name}: points are missing")
    own = data.get("corner", CORNER)
    if isinstance(own, bool) or not isinstance(own, (int, float)):
        raise ValueError(f"{file.name}: corner must be a number [mm], got {own!r}")
    try:
        points = MM * np.array(data["points"], dtype=np.float64)
        return rounded(points, MM * own if corner is None else corner)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{file.name}: {error}") from error
