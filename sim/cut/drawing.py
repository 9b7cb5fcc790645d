"""Contours of drawings (DXF).

A drawing has one closed polyline or circle, in its units (millimetres if it has none), around its
middle: its place in the drawing does not count. Anything else is refused, as it would not be cut.
Arcs of a polyline must join smoothly; corners of one of lines alone are rounded.
"""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .contour import Circle, ClosedCurve
from .polyline import MM, as_drawn, rounded


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
