"""Paths of the tool by arc length: a plane contour placed in space, with leads."""

from dataclasses import dataclass, field
from functools import cached_property

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
    """A plane in base axes: p_base = origin + axes[:, :2] @ p.

    Columns of `axes` are its x, its y and its normal.
    """

    origin: Array
    """(3,) [m]."""
    axes: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3), a rotation matrix; the default is the base x-y plane."""

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
        """The plane through `origin` with that normal; its +x is the base x axis projected into it.

        Where the normal is (nearly) the base x axis itself, the base y axis is projected instead.
        The normal is turned upwards if it points down, so that counter-clockwise means the same as
        in the base x-y plane.
        """
        z = _unit("normal", normal)
        z = -z if z[2] < 0.0 else z
        along = np.eye(3)[0] if abs(z[0]) < 0.999 else np.eye(3)[1]
        x = _unit("plane axis", along - (along @ z) * z)
        return cls(np.asarray(origin, dtype=np.float64), np.stack([x, np.cross(z, x), z], axis=1))

    def to_base(self, p: Array) -> Array:
        """Points of the plane (..., 2) as points in base axes (..., 3)."""
        return self.origin + p @ self.axes[:, :2].T

    def from_base(self, p_base: Array) -> Array:
        """Points in base axes (..., 3) as (x, y, height over the plane), (..., 3)."""
        return (p_base - self.origin) @ self.axes


NODES = 2001
"""Of the table that turns arc length into the parameter of the contour."""


@dataclass(frozen=True)
class Spiral:
    """The contour under a scale that grows to 1, reached with its first two derivatives zero:

        p(x) = scale(x) contour(end - span (1 - x)),  scale(x) = 1 - (1 - inner) (1 - x)^3

    for x from 0 to 1, so position, direction and curvature join those of the contour. `span` is the
    stretch of contour passed; it follows from the length asked for.
    """

    curve: ClosedCurve
    end: float
    """Arc length of the contour where the spiral meets it [m]."""
    length: float
    """[m], of the spiral."""
    inner: float
    """Scale where it starts."""

    def point(self, s: ArrayLike) -> Array:
        """Shape (..., 2) [m], s from 0 to `length`."""
        return self._at(self._parameter(np.asarray(s, dtype=np.float64)), self._span)

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector along increasing s, shape (..., 2)."""
        x = self._parameter(np.asarray(s, dtype=np.float64))
        velocity = self._velocity(x, self._span)
        return velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature [m]."""
        s = np.linspace(0.0, self.length, NODES)
        turn = np.unwrap(np.arctan2(*self.tangent(s).T[::-1]))
        return float(1.0 / np.max(np.abs(np.diff(turn) / np.diff(s))))

    def _at(self, x: Array, span: float) -> Array:
        scale = 1.0 - (1.0 - self.inner) * (1.0 - x) ** 3
        return scale[..., np.newaxis] * self.curve.point(self.end - span * (1.0 - x))

    def _velocity(self, x: Array, span: float) -> Array:
        """Derivative by x."""
        on_contour = self.end - span * (1.0 - x)
        scale = 1.0 - (1.0 - self.inner) * (1.0 - x) ** 3
        growth = 3.0 * (1.0 - self.inner) * (1.0 - x) ** 2
        along = (span * scale)[..., np.newaxis] * self.curve.tangent(on_contour)
        return along + growth[..., np.newaxis] * self.curve.point(on_contour)

    def _way(self, span: float) -> Array:
        """(NODES,) [m], arc length at even steps of x: Simpson's rule on each."""
        x = np.linspace(0.0, 1.0, NODES)
        h = x[1]
        speed = np.linalg.norm(self._velocity(x, span), axis=1)
        middle = np.linalg.norm(self._velocity(x[:-1] + h / 2, span), axis=1)
        steps = (speed[:-1] + 4.0 * middle + speed[1:]) * h / 6.0
        return np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def _span(self) -> float:
        """For which the spiral has its length: bisection, it grows with the span."""
        low, high = 0.0, self.length / self.inner
        if self._way(low)[-1] > self.length:
            raise ValueError(
                f"a lead-in of {self.length:g} m is too short to spiral from {self.inner:g} of the "
                f"contour's size: it needs {self._way(low)[-1]:g} m"
            )
        for _ in range(50):
            span = 0.5 * (low + high)
            low, high = (span, high) if self._way(span)[-1] < self.length else (low, span)
        return 0.5 * (low + high)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        return self._way(self._span), np.linspace(0.0, 1.0, NODES)

    def _parameter(self, s: Array) -> Array:
        """x at arc length s: the table, then two steps of Newton's method."""
        way, nodes = self._table
        x = np.interp(s, way, nodes)
        for _ in range(2):
            below = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, NODES - 2)
            h = x - nodes[below]
            speeds = [
                np.linalg.norm(self._velocity(nodes[below] + h * part, self._span), axis=-1)
                for part in (0.0, 0.5, 1.0)
            ]
            reached = way[below] + (speeds[0] + 4.0 * speeds[1] + speeds[2]) * h / 6.0
            x = np.clip(x - (reached - s) / speeds[2], 0.0, 1.0)
        return x


@dataclass(frozen=True, kw_only=True)
class CuttingPath:
    """A contour cut once, with a lead-in and a lead-out.

    s = 0 is the start of the lead-in. Without a spiral the leads run along the contour itself and
    start at the curve's own s = 0 (on the circle: at +x), so the start pose of the robot does not
    depend on the lead-in. The contour is one full turn after it.
    """

    curve: ClosedCurve
    plane: Plane
    lead_in: float
    """[m]."""
    lead_out: float
    """[m], along the contour."""
    spiral: float | None = None
    """The lead-in starts on the contour shrunk to this share of its size, in (0, 1), and spirals
    outwards: the first hole is cut inside what is thrown away. The contour then starts where a
    lead-in along it would have ended."""

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
        """Lead-in and lead-out of the fraction `lead` of a turn each."""
        length = lead * curve.length
        return cls(curve=curve, plane=plane, lead_in=length, lead_out=length, spiral=spiral)

    @property
    def contour_start(self) -> float:
        """Arc length where the cut begins [m]."""
        return self.lead_in

    @property
    def contour_end(self) -> float:
        """Arc length where the cut is closed [m]."""
        return self.lead_in + self.curve.length

    @property
    def length(self) -> float:
        """[m], leads included."""
        return self.contour_end + self.lead_out

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature [m], of contour and spiral."""
        return min(
            self.curve.smallest_radius, self._spiral.smallest_radius if self._spiral else np.inf
        )

    def position(self, s: ArrayLike) -> Array:
        """Shape (..., 3) [m], base axes."""
        s = np.asarray(s, dtype=np.float64)
        p = self.curve.point(s)
        if self._spiral:
            inside = (s < self.lead_in)[..., np.newaxis]
            p = np.where(inside, self._spiral.point(np.minimum(s, self.lead_in)), p)
        return self.plane.to_base(p)

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector along the motion, shape (..., 3), base axes."""
        s = np.asarray(s, dtype=np.float64)
        t = self.curve.tangent(s)
        if self._spiral:
            inside = (s < self.lead_in)[..., np.newaxis]
            t = np.where(inside, self._spiral.tangent(np.minimum(s, self.lead_in)), t)
        return t @ self.plane.axes[:, :2].T

    @cached_property
    def _spiral(self) -> Spiral | None:
        if self.spiral is None or self.lead_in == 0.0:
            return None
        return Spiral(self.curve, self.lead_in, self.lead_in, self.spiral)
