"""Contours by the name of their shape and one size."""

from collections.abc import Mapping

from .contour import Circle, ClosedCurve, hexagon, slot, square

RADII: Mapping[str, float] = {"circle": 0.005, "square": 0.010, "slot": 0.015, "hexagon": 0.010}
"""[m] by shape, where none is given; of a circle as in thesis 9.2. See `contour_of`."""
CORNER = 0.15
"""Corner radius over size: 40 mm/s around a corner of 3 mm is below what the planner allows."""


def contour_of(shape: str, radius: float) -> ClosedCurve:
    """Contour around the origin of its plane.

    radius: [m], of a circle; half the side of a square, the width across flats of a hexagon, or
        the length of a slot, which is a third as wide.

    Raises ValueError for an unknown shape, or a radius that is not positive.
    """
    if shape not in RADII:
        raise ValueError(f"Unknown shape {shape!r}. Shapes: {', '.join(RADII)}")
    size = 2.0 * radius
    match shape:
        case "circle":
            return Circle(radius)
        case "slot":
            return slot(size, size / 3.0)
        case "square":
            return square(size, CORNER * size)
        case _:
            return hexagon(size, CORNER * size)
