"""Paths of the tool by arc length: a plane contour in space, with lead-in and lead-out.

The lead-in follows the contour itself, or a `Spiral` from inside it.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .contour import ClosedCurve


def _unit(name: str, vector: ArrayLike) -> Array:
    value = np.asarray(vector, dtype=np.float64)
    if value.shape != (3,) or not np.all(np.isfinite(value)):
        raise ValueError(f"{name} must be three finite numbers, got {vector}")
    norm = np.linalg.norm(value)
    if norm < 1e-9:
        raise ValueError(f"{name} must not be the zero vector")
    return value / norm


@dataclass(frozen=True)
class Plane:
    """Plane in base axes: p_base = origin + axes[:, :2] @ p."""

    origin: Array
    """(3,) [m]."""
    axes: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3), a rotation matrix, its x, y and normal; the default is the base x-y plane."""

    def __post_init__(self) -> None:
        origin = np.array(self.origin, dtype=np.float64)
        axes = np.array(self.axes, dtype=np.float64)
        if origin.shape != (3,) or not np.all(np.isfinite(origin)):
            raise ValueError(f"origin must be three finite numbers, got {self.origin}")
        if axes.shape != (3, 3) or not np.allclose(axes.T @ axes, np.eye(3), atol=1e-9):
            raise ValueError("axes must be a 3x3 rotation matrix")
        for name, value in (("origin", origin), ("axes", axes)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @classmethod
    def perpendicular_to(cls, normal: ArrayLike, origin: ArrayLike) -> "Plane":
        """Plane through `origin` with that normal; its +x is the projected base x axis.

        Where the normal is (nearly) the base x axis itself, the base y axis is projected instead. A
        normal that points down is reversed: counter-clockwise is as in the base x-y plane.
        """
        z = _unit("normal", normal)
        z = -z if z[2] < 0.0 else z
        along = np.eye(3)[0] if abs(z[0]) < 0.999 else np.eye(3)[1]
        x = _unit("plane axis", along - (along @ z) * z)
        return cls(np.asarray(origin, dtype=np.float64), np.stack([x, np.cross(z, x), z], axis=1))

    def to_base(self, p: Array) -> Array:
        """Points (..., 3) in base axes of points (..., 2) of the plane."""
        return self.origin + p @ self.axes[:, :2].T

    def from_base(self, p_base: Array) -> Array:
        """Points (x, y, height over the plane), (..., 3), of points (..., 3) in base axes."""
        return (p_base - self.origin) @ self.axes


NODES = 2001
"""Nodes of the table of arc length over the parameter of the spiral."""


@dataclass(frozen=True)
class Spiral:
    """Lead-in that spirals outwards: the contour under a scale that grows to 1.

        p(x) = scale(x) contour(length - span (1 - x)),  scale(x) = 1 - (1 - inner) (1 - x)^3

    for x from 0 to 1. The first two derivatives of the scale end at zero, so that position,
    direction and curvature join those of the contour. `span` [m] is the part of the contour that is
    passed; it follows from the length.
    """

    curve: ClosedCurve
    length: float
    """[m], of the spiral, and arc length of the contour at its end."""
    inner: float
    """Scale at its start."""

    def point(self, s: ArrayLike) -> Array:
        """Shape (..., 2) [m], s from 0 to `length`."""
        x = self._parameter(np.asarray(s, dtype=np.float64))
        scale = 1.0 - (1.0 - self.inner) * (1.0 - x) ** 3
        return scale[..., np.newaxis] * self.curve.point(self.length - self._span * (1.0 - x))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector along increasing s, shape (..., 2)."""
        velocity = self._velocity(self._parameter(np.asarray(s, dtype=np.float64)), self._span)
        return velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature [m]."""
        s = np.linspace(0.0, self.length, NODES)
        heading = np.unwrap(np.arctan2(*self.tangent(s).T[::-1]))
        return float(1.0 / np.max(np.abs(np.diff(heading) / np.diff(s))))

    def _velocity(self, x: Array, span: float) -> Array:
        on_contour = self.length - span * (1.0 - x)
        scale = 1.0 - (1.0 - self.inner) * (1.0 - x) ** 3
        growth = 3.0 * (1.0 - self.inner) * (1.0 - x) ** 2
        along = (span * scale)[..., np.newaxis] * self.curve.tangent(on_contour)
        return along + growth[..., np.newaxis] * self.curve.point(on_contour)

    def _arc_length(self, span: float) -> Array:
        """(NODES,) [m], at even steps of x: Simpson's rule on each."""
        x = np.linspace(0.0, 1.0, NODES)
        h = x[1]
        speed = np.linalg.norm(self._velocity(x, span), axis=1)
        middle = np.linalg.norm(self._velocity(x[:-1] + h / 2, span), axis=1)
        steps = (speed[:-1] + 4.0 * middle + speed[1:]) * h / 6.0
        return np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def _span(self) -> float:
        """Span at which the spiral has its length: bisection, the length grows with it."""
        low, high = 0.0, self.length / self.inner
        if self._arc_length(low)[-1] > self.length:
            raise ValueError(
                f"a lead-in of {self.length:g} m is too short to spiral from {self.inner:g} of the "
                f"contour's size: it needs {self._arc_length(low)[-1]:g} m"
            )
        for _ in range(50):
            span = 0.5 * (low + high)
            low, high = (span, high) if self._arc_length(span)[-1] < self.length else (low, span)
        return 0.5 * (low + high)

    @cached_property
    def _table(self) -> Array:
        return self._arc_length(self._span)

    def _parameter(self, s: Array) -> Array:
        """x at arc length s: the table, then two steps of Newton's method."""
        arc_length, nodes = self._table, np.linspace(0.0, 1.0, NODES)
        x = np.interp(s, arc_length, nodes)
        for _ in range(2):
            below = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, NODES - 2)
            h = x - nodes[below]
            at = (nodes[below] + h * part for part in (0.0, 0.5, 1.0))
            first, mid, last = (np.linalg.norm(self._velocity(y, self._span), axis=-1) for y in at)
            reached = arc_length[below] + (first + 4.0 * mid + last) * h / 6.0
            x = np.clip(x - (reached - s) / last, 0.0, 1.0)
        return x


@dataclass(frozen=True, kw_only=True)
class CuttingPath:
    """Path over a contour once, with a lead-in and a lead-out.

    s = 0 is the start of the lead-in. Without a spiral the leads run along the contour itself and
    start at the curve's own s = 0 (on the circle: at +x), so the start pose of the robot does not
    depend on the lead-in. The contour is one full turn after it.
    """

    curve: ClosedCurve
    plane: Plane
    lead_in: float
    lead_out: float
    """[m]; the lead-out is along the contour."""
    spiral: float | None = None
    """Scale of the contour on which a spiral lead-in starts, in (0, 1). The contour then starts at
    the end of an equally long lead-in along it."""

    def __post_init__(self) -> None:
        for name in ("lead_in", "lead_out"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} must be >= 0 m, got {value}")
        if self.spiral is not None and not 0.0 < self.spiral < 1.0:
            raise ValueError(f"spiral must be between 0 and 1, got {self.spiral}")

    @classmethod
    def around(
        cls, curve: ClosedCurve, plane: Plane, *, lead: float = 0.1, spiral: float | None = None
    ) -> "CuttingPath":
        """Path with lead-in and lead-out of `lead` times the length of the contour each."""
        length = lead * curve.length
        return cls(curve=curve, plane=plane, lead_in=length, lead_out=length, spiral=spiral)

    @property
    def length(self) -> float:
        """[m], leads included."""
        return self.lead_in + self.curve.length + self.lead_out

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature [m], of contour and spiral."""
        of_spiral = self._spiral.smallest_radius if self._spiral else np.inf
        return min(self.curve.smallest_radius, of_spiral)

    def position(self, s: ArrayLike) -> Array:
        """Shape (..., 3) [m], base axes."""
        return self.plane.to_base(self._in_plane(s, "point"))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector along the motion, shape (..., 3), base axes."""
        return self._in_plane(s, "tangent") @ self.plane.axes[:, :2].T

    def _in_plane(self, s: ArrayLike, quantity: Literal["point", "tangent"]) -> Array:
        s = np.asarray(s, dtype=np.float64)
        p = getattr(self.curve, quantity)(s)
        if self._spiral is None:
            return p
        on_spiral = getattr(self._spiral, quantity)(np.minimum(s, self.lead_in))
        return np.where((s < self.lead_in)[..., np.newaxis], on_spiral, p)

    @cached_property
    def _spiral(self) -> Spiral | None:
        if self.spiral is None or self.lead_in == 0.0:
            return None
        return Spiral(self.curve, self.lead_in, self.spiral)
