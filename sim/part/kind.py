"""Kinds of contours."""

from enum import Enum


class Kind(Enum):
    """Kind of a contour by its place in the part."""

    OUTLINE = "outline"
    """The material is inside; cut last."""
    HOLE = "hole"
    """The scrap is inside."""
    OPEN = "open"
    """A cut along a line, scrap on neither side."""
