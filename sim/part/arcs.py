"""Chains of lines and arcs in a plane, with corners, open or closed.

Other smooth curves are fitted by arcs that join smoothly, within a tolerance.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ..motion.contour import chord

MM = 1e-3
SAGITTA = 1e-6
"""Largest distance between an arc and the polygon that stands for it [m]."""
TOLERANCE = 1e-6
"""Largest distance between a curve and its arcs [m]."""
DEEPEST = 16
"""Most times a curve is halved."""
CHECKS = np.linspace(0.0, 1.0, 9)[1:-1]
PointAndTangent = Callable[[float], tuple[Array, Array]]
"""Point (2,) [m] and tangent (2,), of any length, at a parameter."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Elements from point to point, each a line or an arc of at most half a turn."""

    points: Array
    """(K + 1, 2) [m]."""
    bulge: Array
    """(K,), tangent of a quarter of each element's angle: 0 for a line, above 0 turns left."""

    @property
    def closed(self) -> bool:
        return bool(np.array_equal(self.points[0], self.points[-1]))

    @cached_property
    def angle(self) -> Array:
        """(K,) [rad], by which each element turns."""
        return 4.0 * np.arctan(self.bulge)

    @cached_property
    def lengths(self) -> Array:
        """(K,) [m]."""
        return self._chord_length / np.sinc(self.angle / (2.0 * np.pi))

    @cached_property
    def curvature(self) -> Array:
        """(K,) [1/m]."""
        return self.angle / self.lengths

    @cached_property
    def heading(self) -> Array:
        """(K,) [rad], direction of each element at its start."""
        dx, dy = np.diff(self.points, axis=0).T
        return np.arctan2(dy, dx) - self.angle / 2.0

    @property
    def length(self) -> float:
        return float(self.lengths.sum())

    @cached_property
    def ends(self) -> Array:
        """(K + 1,) [m], arc length at each of the points."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def area(self) -> float:
        """Enclosed area [m^2], above 0 if counter-clockwise."""
        (x, y), (u, v) = self.points[:-1].T, self.points[1:].T
        half = self.angle / 2.0
        radius = np.divide(self._chord_length / 2.0, np.sin(half), where=half != 0.0, out=0 * half)
        return float(0.5 * np.sum(x * v - u * y + radius**2 * (self.angle - np.sin(self.angle))))

    @cached_property
    def kinks(self) -> Array:
        """(K,) [rad], change of direction to each start; that of the first from the last, or 0."""
        kink = wrapped(self.heading - np.roll(self.heading + self.angle, 1))
        if not self.closed:
            kink[0] = 0.0
        return kink

    @property
    def reversed(self) -> "Chain":
        return Chain(self.points[::-1], -self.bulge[::-1])

    def ending_at_start(self, near: float = np.inf) -> "Chain":
        """The chain with its first point in place of its last, where those are that near [m]."""
        if np.linalg.norm(self.points[-1] - self.points[0]) > near:
            return self
        return Chain(np.vstack([self.points[:-1], self.points[:1]]), self.bulge)

    def point(self, s: ArrayLike) -> Array:
        """Points (..., 2) at arc lengths s [m] from 0 to `length`."""
        return self._on(*self._locate(s))

    def direction(self, s: ArrayLike) -> Array:
        """Headings [rad] at arc lengths s [m]."""
        element, along = self._locate(s)
        return self.heading[element] + self.curvature[element] * along

    def curvature_at(self, s: ArrayLike) -> Array:
        """Curvature [1/m] at arc lengths s [m]."""
        return self.curvature[self._locate(s)[0]]

    def part(self, first: float, last: float) -> "Chain":
        """The chain between two arc lengths [m]."""
        inside = (self.ends > first + 1e-9) & (self.ends < last - 1e-9)
        cuts = np.concatenate([[first], self.ends[inside], [last]])
        element, _ = self._locate(0.5 * (cuts[:-1] + cuts[1:]))
        bulge = np.tan(self.curvature[element] * np.diff(cuts) / 4.0)
        return Chain(self.point(cuts), bulge)

    def polygon(self, sagitta: float = SAGITTA) -> Array:
        """Points (N, 2) of an inscribed polygon; the last one repeats the first if closed."""
        bend = np.abs(self.curvature)
        step = np.sqrt(8.0 * sagitta / np.maximum(bend, 1e-12))
        parts = np.maximum(1, np.ceil(self.lengths / step)).astype(int)
        element = np.repeat(np.arange(len(parts)), parts)
        before = np.concatenate([[0], np.cumsum(parts)[:-1]])
        fraction = (np.arange(len(element)) - before[element]) / parts[element]
        s = self.ends[element] + self.lengths[element] * fraction
        return np.vstack([self._on(element, s - self.ends[element]), self.points[-1:]])

    def _locate(self, s: ArrayLike) -> tuple[NDArray[np.int64], Array]:
        at = np.asarray(s, dtype=np.float64)
        element = np.searchsorted(self.ends, at, side="right") - 1
        element = np.clip(element, 0, len(self.bulge) - 1).astype(np.int64)
        return element, at - self.ends[element]

    def _on(self, element: NDArray[np.int64], along: Array) -> Array:
        """Points (..., 2) on elements, at lengths [m] from their starts."""
        step = chord(along, self.curvature[element], self.heading[element])
        return self.points[element] + step

    @cached_property
    def _chord_length(self) -> Array:
        return np.linalg.norm(np.diff(self.points, axis=0), axis=1)


def wrapped(angle: ArrayLike) -> Array:
    """Angle in (-pi, pi]."""
    return np.pi - np.mod(np.pi - np.asarray(angle), 2.0 * np.pi)


def line(*points: ArrayLike) -> Chain:
    """Straight lines from point to point."""
    return Chain(np.array(points, dtype=np.float64), np.zeros(len(points) - 1))


def arc(centre: ArrayLike, radius: float, start: float, angle: float) -> Chain:
    """Arc from an angle `start` [rad] on by `angle`, above 0 counter-clockwise."""
    parts = max(1, int(np.ceil(abs(angle) / np.pi - 1e-9)))
    at = start + angle * np.linspace(0.0, 1.0, parts + 1)
    points = np.asarray(centre) + radius * np.stack([np.cos(at), np.sin(at)], axis=1)
    if abs(abs(angle) - 2.0 * np.pi) < 1e-12:
        points[-1] = points[0]
    return Chain(points, np.full(parts, np.tan(angle / parts / 4.0)))


def polyline(points: Array, bulge: Array) -> Chain:
    """Chain of points (K + 1, 2) and any bulges (K,); one above 1 is of two arcs, by its middle."""
    (dx, dy), large = np.diff(points, axis=0).T, np.abs(bulge) > 1.0 + 1e-9
    middle = 0.5 * (points[:-1] + points[1:]) + 0.5 * bulge[:, None] * np.stack([dy, -dx], axis=1)
    halves = np.where(large, np.tan(np.arctan(bulge) / 2.0), bulge)
    places = np.flatnonzero(large) + 1
    return Chain(np.insert(points, places, middle[large], 0), np.repeat(halves, 1 + large))


def joined(chains: Iterable[Chain]) -> Chain:
    """Chains one after the other, each start at the end of the one before."""
    every = list(chains)
    points = np.vstack([every[0].points, *(c.points[1:] for c in every[1:])])
    return Chain(points, np.concatenate([c.bulge for c in every]))


def place(point: ArrayLike) -> str:
    """A point [m] in the words of a message."""
    x, y = np.round(np.asarray(point) / MM, 2) + 0.0
    return f"({x:g}, {y:g}) mm"


def biarc(p: Array, along_p: Array, q: Array, along_q: Array) -> Chain:
    """Two arcs from p to q with unit tangents at both, of equal control lengths.

    The joint follows from |q - p - d (along_p + along_q)| = 2 d. Bolton, "Biarc curves",
    Computer-Aided Design 7(2), 1975.
    """
    v, both = q - p, along_p + along_q
    straight = 2.0 * (1.0 - along_p @ along_q)
    vb = v @ both
    if straight < 1e-12:
        d = v @ v / (2.0 * vb) if abs(vb) > 1e-12 * np.linalg.norm(v) else np.inf
    else:
        d = (-vb + np.sqrt(vb**2 + straight * (v @ v))) / straight
    middle = 0.5 * (p + q) if not np.isfinite(d) else 0.5 * (p + q + d * (along_p - along_q))
    half = (_angle(along_p, middle - p), _angle(q - middle, along_q))
    return Chain(np.array([p, middle, q]), np.tan(np.array(half) / 2.0))


def ellipse(centre: Array, major: Array, minor: Array, sense: float = 1.0) -> PointAndTangent:
    """By the angle; `major` and `minor` are half axes, or any conjugate half diameters."""
    return lambda t: (
        centre + np.cos(t) * major + np.sin(t) * minor,
        sense * (np.cos(t) * minor - np.sin(t) * major),
    )


def fitted(curve: PointAndTangent, breaks: Array | list[float], deeper: int = DEEPEST) -> Chain:
    """Arcs along a curve that is smooth between `breaks`; ValueError where none come near."""
    ends = ((float(lower), float(upper)) for lower, upper in pairwise(breaks))
    return joined(_fitted(curve, lower, upper, deeper) for lower, upper in ends)


def _fitted(curve: PointAndTangent, lower: float, upper: float, deeper: int) -> Chain:
    arcs = biarc(*_unit(curve, lower, upper), *_unit(curve, upper, lower))
    between = np.array([curve(lower + (upper - lower) * x)[0] for x in CHECKS])
    if np.abs(arcs.angle).max() < np.pi / 3 and _off(arcs, between) <= TOLERANCE:
        return arcs
    if deeper == 0:
        raise ValueError("the curve has a cusp or is not smooth")
    return fitted(curve, [lower, 0.5 * (lower + upper), upper], deeper - 1)


def _unit(curve: PointAndTangent, at: float, towards: float) -> tuple[Array, Array]:
    """Point and unit tangent; where the tangent vanishes, that a little further inside."""
    point, tangent = curve(at)
    inside = at
    for part in (1e-6, 1e-4, 1e-2):
        if np.linalg.norm(tangent) > 1e-9 * np.linalg.norm(curve(0.5 * (at + towards))[1]):
            break
        inside = at + part * (towards - at)
        tangent = curve(inside)[1]
    size = np.linalg.norm(tangent)
    if size == 0.0:
        raise ValueError("the curve has no direction")
    return point, tangent / size


def _off(arcs: Chain, points: Array) -> float:
    """Largest distance of points from the nearer of two arcs."""
    normal, bend = np.array([-np.sin(arcs.heading), np.cos(arcs.heading)]), arcs.curvature
    offset = points[:, np.newaxis] - arcs.points[:-1]
    # (|offset - normal / k| - 1 / k), without the difference of two large numbers
    square = bend * np.sum(offset**2, axis=2) - 2.0 * np.einsum("mij,ji->mi", offset, normal)
    distance = np.abs(square) / (1.0 + np.sqrt(np.maximum(1.0 + bend * square, 0.0)))
    return float(distance.min(axis=1).max())


def _angle(a: Array, b: Array) -> float:
    """From a to b [rad], in (-pi, pi]."""
    return float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
