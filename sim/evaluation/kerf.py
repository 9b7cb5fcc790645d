"""Kerf: the material that a round beam removes along its path, and the shape of its edges."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..motion.contour import ClosedCurve, outward_normal
from .tool_error import fit, signed_distance

POINTS = 720
"""Points along the contour at which the edges are computed."""
_DISCS_PER_RADIUS = 20  # steps of the beam so small that scallops are 1/3000 of its radius
_MOST_INSIDE = 0.9  # largest distance of a path inside a bend, over its radius


@dataclass(frozen=True, kw_only=True)
class Kerf:
    """Edges of a cut around a contour, at points along it."""

    curve: ClosedCurve
    """The programmed contour."""
    beam: float
    """Diameter [m]."""
    arc_length: Array
    """(M,) [m], of the contour."""
    outer: Array
    inner: Array
    """(M,) [m], outwards from the contour, edges of the hole and of the fallen piece (below 0)."""

    @property
    def width(self) -> Array:
        """(M,) [m]."""
        return self.outer - self.inner

    def edge(self, offset: Array) -> Array:
        """Points (M, 2) [m] in the plane, `offset` outwards from the contour."""
        normal = outward_normal(self.curve.tangent(self.arc_length))
        return self.curve.point(self.arc_length) + offset[:, np.newaxis] * normal

    @property
    def hole_deviation(self) -> Array:
        """(M,) [m], deviation of the hole's edge from the programmed one, fitted; NaN with gaps."""
        if not np.isfinite(self.outer).all():
            return np.full_like(self.outer, np.nan)
        # The programmed edge lies half a beam outside the contour: subtracted along the normals.
        return fit(self.curve, self.edge(self.outer - 0.5 * self.beam)).deviation

    @property
    def roundness(self) -> float:
        """Width [m] of the band around the hole's programmed edge that has the actual one."""
        return float(np.ptp(self.hole_deviation))


def kerf(curve: ClosedCurve, path: Array, beam: float, *, closed: bool = True) -> Kerf:
    """Edges of the area that a disc of diameter `beam` [m] sweeps along a path.

    path: (K, 2) [m], centre of the beam in the plane of the contour, registered on it; the last
    point is joined to the first if closed. The edges are NaN for a path that is not finite.
    """
    if not beam > 0.0:
        raise ValueError(f"beam must be > 0 m, got {beam}")
    step = curve.length / POINTS
    s: Array = (np.arange(POINTS, dtype=np.float64) + 0.5) * step
    outer, inner = np.full(POINTS, -np.inf), np.full(POINTS, np.inf)
    if len(path) and np.isfinite(path).all():
        radius = 0.5 * beam
        swept = np.vstack([path, path[:1]]) if closed else path
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(swept, axis=0), axis=1))])
        n_discs = int(np.ceil(along[-1] / (radius / _DISCS_PER_RADIUS))) + 1
        at = np.linspace(0.0, along[-1], n_discs)
        discs = np.column_stack([np.interp(at, along, column) for column in swept.T])
        foot, tangent = curve.point(s), curve.tangent(s)
        normal = outward_normal(tangent)
        nearest = np.rint(curve.nearest(discs) / step - 0.5).astype(int)
        # To the contour points whose normals a disc can meet: inside a bend they are closer.
        inside = np.abs(signed_distance(curve, path)).max() / curve.smallest_radius
        n = int(np.ceil(radius / (step * (1.0 - min(inside, _MOST_INSIDE))))) + 1
        for shift in range(-n, n + 1):
            i = (nearest + shift) % POINTS
            offset = discs - foot[i]
            along = np.einsum("ij,ij->i", offset, tangent[i])
            hit = np.abs(along) < radius
            i, half = i[hit], np.sqrt(radius**2 - along[hit] ** 2)
            across = np.einsum("ij,ij->i", offset[hit], normal[i])
            np.maximum.at(outer, i, across + half)
            np.minimum.at(inner, i, across - half)
    cut = np.isfinite(outer)
    outer, inner = np.where(cut, outer, np.nan), np.where(cut, inner, np.nan)
    return Kerf(curve=curve, beam=beam, arc_length=s, outer=outer, inner=inner)
