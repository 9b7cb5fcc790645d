"""A lead-in that spirals outwards onto a contour, by arc length."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .contour import ClosedCurve

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
