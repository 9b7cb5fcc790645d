"""Paint of SVG shapes: what is invisible, and what is the background of the page."""

from typing import Any

PAGE = 1e-3
"""Relative difference from the page within which a filled rectangle is its background."""


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
