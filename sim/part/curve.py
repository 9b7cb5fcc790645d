"""Contours of a part as curves that a measured path is compared with."""

from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..motion.contour import Circle, ClosedCurve
from .arcs import Chain

SPACING = 1e-3
"""Largest distance of the points that the search for a nearest point starts from [m]."""
STEPS = 4
"""Newton steps of that search; on a line or an arc the first is exact."""
BEZIER = 3e-4
"""Relative differences of radius within which a closed chain stands for a circle: the four cubic
curves that other programs write differ by 2.7e-4."""
ROUND = 1e-6
"""Relative differences of curvature within which a closed chain is a circle."""


class Kind(Enum):
    """Kind of a contour by its place in the part."""

    OUTLINE = "outline"
    """The material is inside; cut last."""
    HOLE = "hole"
    """The scrap is inside."""
    OPEN = "open"
    """A cut along a line, scrap on neither side."""


if TYPE_CHECKING:
    from scipy.spatial import KDTree


@dataclass(frozen=True, eq=False)
class ChainCurve:
    """A chain by arc length: taken modulo its length if closed, otherwise held at its ends."""

    chain: Chain = field(repr=False)

    @property
    def length(self) -> float:
        return self.chain.length

    @property
    def smallest_radius(self) -> float:
        """[m], infinite for lines alone."""
        return float(1.0 / max(np.abs(self.chain.curvature).max(), 1e-12))

    def point(self, s: ArrayLike) -> Array:
        """Shape (..., 2) [m]."""
        return self.chain.point(self._within(s))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector along increasing s, shape (..., 2)."""
        heading = self.chain.direction(self._within(s))
        return np.stack([np.cos(heading), np.sin(heading)], axis=-1)

    def nearest(self, p: Array) -> Array:
        """Arc length of the nearest point to each of p (N, 2)."""
        tree, places = self._table
        closest, row = tree.query(p)
        s = best = places[row]
        for _ in range(STEPS):  # of Newton towards each foot
            offset, along = p - self.point(s), self.tangent(s)
            across = along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]
            # On an arc the foot moves faster or slower than the point, by its distance.
            stretch = np.maximum(1.0 - self.chain.curvature_at(s) * across, 0.2)
            step = np.einsum("ij,ij->i", offset, along) / stretch
            s = self._within(s + np.clip(step, -SPACING, SPACING))
            distance = np.linalg.norm(p - self.point(s), axis=1)
            # Beside a corner the step leads from one side to the other and back.
            best, closest = np.where(distance < closest, (s, distance), (best, closest))
        return best

    def _within(self, s: ArrayLike) -> Array:
        s = np.asarray(s, dtype=np.float64)
        return np.mod(s, self.length) if self.chain.closed else np.clip(s, 0.0, self.length)

    @cached_property
    def _table(self) -> "tuple[KDTree, Array]":
        from scipy.spatial import KDTree

        n = int(np.ceil(self.length / SPACING)) + 8
        places = np.union1d(np.linspace(0.0, self.length, n), self.chain.ends[:-1])
        return KDTree(self.chain.point(places)), places


def centred(chain: Chain) -> tuple[ClosedCurve, Array]:
    """The chain as a curve around its middle, a circle where it is one; and the middle (2,) [m]."""
    if is_circle(chain):
        radius = 1.0 / chain.curvature[0]
        heading = chain.heading[0]
        centre = chain.points[0] + radius * np.array([-np.sin(heading), np.cos(heading)])
        return Circle(abs(float(radius))), centre
    s = (np.arange(1000) + 0.5) * chain.length / 1000
    middle = chain.point(s).mean(axis=0)
    radii = np.linalg.norm(chain.point(s) - middle, axis=1)
    if chain.closed and np.ptp(radii) <= BEZIER * radii.mean():
        return Circle(float(radii.mean())), middle  # a best fit could turn it at will
    return ChainCurve(Chain(chain.points - middle, chain.bulge)), middle


def is_circle(chain: Chain) -> bool:
    """Whether a chain is one full turn of one arc."""
    turn = abs(chain.angle.sum()) - 2.0 * np.pi
    even = np.ptp(chain.curvature) <= ROUND * np.abs(chain.curvature).max()
    return bool(chain.closed and abs(turn) < ROUND and even)
