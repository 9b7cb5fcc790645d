"""Paths of the tool by arc length: a plane contour placed in space, with leads."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .contour import ClosedCurve
from .spiral import Spiral


@dataclass(frozen=True)
class Circle:
    """A circle around the origin of its plane; s = 0 on the plane's +x axis."""

    radius: float
    """[m]."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.radius) and self.radius > 0.0):
            raise ValueError(f"radius must be > 0 m, got {self.radius}")

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
