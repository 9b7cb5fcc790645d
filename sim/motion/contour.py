"""Closed contours in a plane: circles, and chains of arcs and lines such as squares and slots.

A `ClosedCurve` is anything with length, curvature radius, point, tangent and nearest point by arc
length; own contours are read by `armside.sim.part.contour_file`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, check_numbers

RADII: Mapping[str, float] = {"circle": 0.005, "square": 0.010, "slot": 0.015, "hexagon": 0.010}
"""[m] by shape, where none is given; of a circle as in thesis 9.2. See `contour_of`."""
CORNER = 0.15
"""Corner radius over size: 40 mm/s around a corner of 3 mm is below what the planner allows."""


class ClosedCurve(Protocol):
    """Closed curve in a plane, traversed counter-clockwise unless it is `clockwise`; s is taken
    modulo `length`."""

    @property
    def length(self) -> float:
        """Length of one turn [m]."""
        ...

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature [m]."""
        ...

    def point(self, s: ArrayLike) -> Array:
        """Shape (..., 2) [m]."""
        ...

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector along increasing s, shape (..., 2)."""
        ...

    def nearest(self, p: Array) -> Array:
        """Arc length of the nearest point of the curve to each of p (N, 2)."""
        ...


@dataclass(frozen=True)
class Circle:
    """Circle around the origin of its plane; s = 0 on the plane's +x axis."""

    radius: float
    """[m]."""

    def __post_init__(self) -> None:
        check_numbers(self, "radius", nan=True)
        _require_positive("radius", self.radius)

    @property
    def length(self) -> float:
        return 2.0 * np.pi * self.radius

    @property
    def smallest_radius(self) -> float:
        return self.radius

    def point(self, s: ArrayLike) -> Array:
        angle = np.asarray(s) / self.radius
        return self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def tangent(self, s: ArrayLike) -> Array:
        angle = np.asarray(s) / self.radius
        return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)

    def nearest(self, p: Array) -> Array:
        return self.radius * np.mod(np.arctan2(p[:, 1], p[:, 0]), 2.0 * np.pi)


CLOSURE = 1e-9
"""Largest gap between end and start of a chain, relative to its length."""


@dataclass(frozen=True)
class ArcsAndLines:
    """Smooth closed chain of arcs and lines."""

    start: tuple[float, float]
    """[m]."""
    elements: tuple[tuple[float, float], ...]
    """Length [m] and curvature [1/m] of each; curvature 0 is a line, above 0 turns left."""

    def __post_init__(self) -> None:
        if not self.elements or not all(length > 0.0 for length, _ in self.elements):
            raise ValueError("every element of a contour must be longer than 0 m")
        gap = np.linalg.norm(self._corners[-1] - self._corners[0])
        angle = sum(length * curvature for length, curvature in self.elements)
        if gap > CLOSURE * self.length or abs(abs(angle) - 2.0 * np.pi) > 1e-9:
            raise ValueError(
                f"the contour does not close: its end is {gap:g} m from its start and it turns by "
                f"{np.degrees(angle):g} deg"
            )

    @property
    def length(self) -> float:
        return float(self._ends[-1])

    @property
    def smallest_radius(self) -> float:
        return 1.0 / max(abs(curvature) for _, curvature in self.elements)

    def point(self, s: ArrayLike) -> Array:
        element, along = self._locate(s)
        bend, heading = self._curvature[element], self._heading[element]
        return self._corners[element] + chord(along, bend, heading)

    def tangent(self, s: ArrayLike) -> Array:
        element, along = self._locate(s)
        angle = self._heading[element] + self._curvature[element] * along
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def nearest(self, p: Array) -> Array:
        best, s = np.full(len(p), np.inf), np.zeros(len(p))
        for i, (length, curvature) in enumerate(self.elements):
            heading, offset = self._heading[i], p - self._corners[i]
            tangent = np.array([np.cos(heading), np.sin(heading)])
            along = np.clip(offset @ tangent, 0.0, length)
            if curvature != 0.0:
                # Angle about the centre of the arc, from its start.
                to_centre = offset @ np.array([-tangent[1], tangent[0]]) - 1.0 / curvature
                side = np.sign(curvature)
                angle = np.arctan2(offset @ tangent * side, -to_centre * side)
                along = np.mod(angle, 2.0 * np.pi) / abs(curvature)
                along = np.minimum(along, length)  # beyond its end another element is as near
            at = self._corners[i] + chord(along, curvature, heading)
            distance = np.linalg.norm(p - at, axis=1)
            closer = distance < best
            best[closer], s[closer] = distance[closer], self._ends[i] + along[closer]
        return s

    def _locate(self, s: ArrayLike) -> tuple[NDArray[np.int64], Array]:
        wrapped = np.mod(np.asarray(s, dtype=np.float64), self.length)
        element = np.searchsorted(self._ends, wrapped, side="right") - 1
        element = np.clip(element, 0, len(self.elements) - 1)
        return element, wrapped - self._ends[element]

    @cached_property
    def _ends(self) -> Array:
        """(E + 1,) [m], arc length at the start of each element and at the end of the last."""
        return np.concatenate([[0.0], np.cumsum([length for length, _ in self.elements])])

    @cached_property
    def _curvature(self) -> Array:
        return np.array([curvature for _, curvature in self.elements])

    @cached_property
    def _heading(self) -> Array:
        """(E,) [rad], direction of each element at its start."""
        angles = [length * curvature for length, curvature in self.elements]
        first = np.copysign(np.pi / 2, sum(angles))
        return first + np.concatenate([[0.0], np.cumsum(angles)[:-1]])

    @cached_property
    def _corners(self) -> Array:
        """(E + 1, 2) [m], start of each element and end of the last."""
        steps = [
            chord(*e, heading) for e, heading in zip(self.elements, self._heading, strict=True)
        ]
        return np.concatenate([[self.start], np.array(self.start) + np.cumsum(steps, axis=0)])


def chord(along: Array | float, curvature: Array | float, heading: Array | float) -> Array:
    """Vector (..., 2) [m] from the start of an element to a point on it; curvature 0 is a line."""
    half = 0.5 * np.asarray(along) * curvature
    length = along * np.sinc(half / np.pi)
    return length[..., np.newaxis] * np.stack([np.cos(heading + half), np.sin(heading + half)], -1)


def outward_normal(tangent: Array) -> Array:
    """Unit normal (N, 2) to the right of tangents (N, 2): outwards if counter-clockwise."""
    return np.column_stack([tangent[:, 1], -tangent[:, 0]])


def square(side: float, corner_radius: float) -> ArcsAndLines:
    """Square with rounded corners; it starts in the middle of its right side."""
    return regular_polygon(4, side, corner_radius)


def hexagon(across_flats: float, corner_radius: float) -> ArcsAndLines:
    """Regular hexagon with two sides along y, `across_flats` [m] apart."""
    return regular_polygon(6, across_flats, corner_radius)


def regular_polygon(n: int, across_flats: float, corner_radius: float) -> ArcsAndLines:
    """Polygon of n sides, each half of `across_flats` [m] from the centre; starts in mid-side."""
    _require_positive("size", across_flats)
    if not 0.0 < corner_radius <= across_flats / 2:
        raise ValueError(
            f"corner radius must be above 0 and at most {across_flats / 2:g} m, got {corner_radius}"
        )
    half = (across_flats / 2 - corner_radius) * np.tan(np.pi / n)
    arc = (2.0 * np.pi / n * corner_radius, 1.0 / corner_radius)
    elements = [(half, 0.0), arc, *([(2.0 * half, 0.0), arc] * (n - 1)), (half, 0.0)]
    return ArcsAndLines((across_flats / 2, 0.0), tuple(e for e in elements if e[0] > 0.0))


def slot(length: float, width: float) -> ArcsAndLines:
    """Slot: two half circles joined by lines along x; it starts at the tip."""
    _require_positive("width", width)
    if not length > width:
        raise ValueError(f"a slot must be longer than wide, got {length} and {width} m")
    radius = width / 2
    quarter, half = (np.pi / 2 * radius, 1.0 / radius), (np.pi * radius, 1.0 / radius)
    line = (length - width, 0.0)
    return ArcsAndLines((length / 2, 0.0), (quarter, line, half, line, quarter))


def clockwise(curve: "Circle | ArcsAndLines") -> ArcsAndLines:
    """The same contour from the same point on, the other way round."""
    if isinstance(curve, Circle):
        return ArcsAndLines((curve.radius, 0.0), ((curve.length, -1.0 / curve.radius),))
    back = tuple((length, -bend) for length, bend in reversed(curve.elements))
    return ArcsAndLines(curve.start, back)


def _require_positive(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} must be > 0 m, got {value}")


def contour_of(shape: str, radius: float) -> ClosedCurve:
    """Contour around the origin of its plane.

    radius: [m], of a circle; half the side of a square, the width across flats of a hexagon, or
        the length of a slot, which is a third as wide.

    Raises ValueError for an unknown shape, or a radius that is not positive.
    """
    size = 2.0 * radius
    match shape:
        case "circle":
            return Circle(radius)
        case "slot":
            return slot(size, size / 3.0)
        case "square" | "hexagon":
            return regular_polygon(4 if shape == "square" else 6, size, CORNER * size)
    raise ValueError(f"Unknown shape {shape!r}. Shapes: {', '.join(RADII)}")
