"""Chain of each type of DXF entity that can be cut."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from armside.arrays import Array

from .biarc import fitted
from .chain import Chain, arc, line, place, polyline

FLAT = 1e-6
"""Largest difference of height within an entity, and of a normal from +-z, relative to 1."""


class NotFlatError(ValueError):
    """The entity is not drawn in the x-y plane."""


def _line(entity: Any, scale: float) -> Chain:
    start, end = entity.dxf.start, entity.dxf.end
    _level([start.z, end.z])
    return line(scale * np.array([start.x, start.y]), scale * np.array([end.x, end.y]))


def _circle(entity: Any, scale: float) -> Chain:
    return _round(entity, scale, 0.0, 2.0 * np.pi)


def _arc(entity: Any, scale: float) -> Chain:
    first, last = np.radians([entity.dxf.start_angle, entity.dxf.end_angle])
    angle = np.mod(last - first, 2.0 * np.pi)
    return _round(entity, scale, first, angle if angle > 1e-9 else 2.0 * np.pi)


def _round(entity: Any, scale: float, start: float, angle: float) -> Chain:
    centre, radius = entity.dxf.center, scale * entity.dxf.radius
    if not radius > 0.0:
        at = place(scale * np.array([centre.x, centre.y]))
        raise ValueError(f"its radius is {entity.dxf.radius:g}, at {at}")
    chain = arc(scale * np.array([centre.x, centre.y]), radius, start, angle)
    return _seen_from_above(entity, chain)


def _ellipse(entity: Any, scale: float) -> Chain:
    tool = entity.construction_tool()
    major, minor = _flat(tool.major_axis, scale), _flat(tool.minor_axis, scale)
    centre = scale * np.array([tool.center.x, tool.center.y])
    first = tool.start_param
    span = np.mod(tool.end_param - first, 2.0 * np.pi)
    span = span if span > 1e-9 else 2.0 * np.pi

    def at(t: float) -> tuple[Array, Array]:
        along = np.cos(t) * minor - np.sin(t) * major
        return centre + np.cos(t) * major + np.sin(t) * minor, along

    return _exactly_closed(fitted(at, first + span * np.linspace(0.0, 1.0, 5)))


def _spline(entity: Any, scale: float) -> Chain:
    tool = entity.construction_tool()
    _level([point.z for point in tool.control_points])
    knots = np.array(tool.knots())
    lower, upper = knots[tool.order - 1], knots[-tool.order]
    inside = knots[(knots >= lower) & (knots <= upper)]

    def at(t: float) -> tuple[Array, Array]:
        point, along = next(iter(tool.derivatives([min(max(t, lower), upper)], 1)))
        return scale * np.array([point.x, point.y]), scale * np.array([along.x, along.y])

    return _exactly_closed(fitted(at, np.unique(inside)))


def _lwpolyline(entity: Any, scale: float) -> Chain:
    vertices = np.array(entity.get_points("xyb"), dtype=np.float64).reshape(-1, 3)
    return _polyline_of(entity, vertices, bool(entity.closed), scale)


def _polyline(entity: Any, scale: float) -> Chain:
    if not (entity.is_2d_polyline or entity.is_3d_polyline):
        raise ValueError("it is a mesh, not a curve")
    frame = 16  # vertex of the control frame of a smoothed polyline, not on the curve
    kept = [v.dxf for v in entity.vertices if not v.dxf.flags & frame]
    _level([v.location.z for v in kept])
    rows = [(v.location.x, v.location.y, v.get("bulge", 0.0)) for v in kept]
    vertices = np.array(rows, dtype=np.float64).reshape(-1, 3)
    return _polyline_of(entity, vertices, bool(entity.is_closed), scale)


def _polyline_of(entity: Any, vertices: Array, closed: bool, scale: float) -> Chain:
    if closed and len(vertices) > 1:
        vertices = np.vstack([vertices, vertices[:1]])
    step = np.linalg.norm(np.diff(vertices[:, :2], axis=0), axis=1)
    # A last vertex on the first of a closed polyline, and doubled vertices, add no element.
    kept = np.concatenate([[True], step > 0.0])
    if kept.sum() < 2:
        at = f" at {place(scale * vertices[0, :2])}" if len(vertices) else ": it has no vertex"
        raise ValueError(f"it has zero length{at}")
    bulge = vertices[:-1, 2][step > 0.0]
    chain = polyline(scale * vertices[kept, :2], bulge)
    return _seen_from_above(entity, chain)


def _seen_from_above(entity: Any, chain: Chain) -> Chain:
    """The chain in world axes: one that is drawn with its normal along -z is mirrored."""
    x, y, z = np.array(entity.dxf.get("extrusion", (0.0, 0.0, 1.0)), dtype=np.float64)
    if abs(x) + abs(y) > FLAT * abs(z):
        raise NotFlatError
    return chain if z > 0.0 else Chain(chain.points * [-1.0, 1.0], -chain.bulge)


def _level(heights: list[float]) -> None:
    if np.ptp(heights) > FLAT * max(1.0, float(np.abs(heights).max())):
        raise NotFlatError


def _flat(vector: Any, scale: float) -> Array:
    if abs(vector.z) > FLAT * vector.magnitude:
        raise NotFlatError
    return scale * np.array([vector.x, vector.y])


def _exactly_closed(chain: Chain) -> Chain:
    """The chain with its last point on the first, where they differ by rounding."""
    first, last = chain.points[0], chain.points[-1]
    if np.linalg.norm(last - first) > 1e-9 * chain.length:
        return chain
    return Chain(np.vstack([chain.points[:-1], first[np.newaxis]]), chain.bulge)


READERS: Mapping[str, Callable[[Any, float], Chain]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "SPLINE": _spline,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
}
"""By type; every other type is refused by name. INSERT is taken apart before."""
