"""How far points lie from a contour, after the rigid motion that brings them closest to it."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from .contour import ClosedCurve

CONVERGED = 1e-12
"""[m] and [rad]: a last step below this."""


@dataclass(frozen=True, kw_only=True)
class Fit:
    """Points in the plane of a contour, moved onto it as well as a rigid motion can."""

    points: Array
    """(N, 2) [m], after the motion."""
    deviation: Array
    """(N,) [m], signed distance from the contour, above 0 outside."""
    shift: Array
    """(2,) [m], where the origin of the contour lies among the points as given."""
    angle: float
    """By which the points were turned [rad]."""


def signed_distance(contour: ClosedCurve, p: Array) -> Array:
    """(N,) [m], above 0 to the right of the contour: outside if it is counter-clockwise."""
    return _distance(contour, p)[0]


def _distance(contour: ClosedCurve, p: Array) -> tuple[Array, Array]:
    """Signed distance of each point, and the normal along which it is."""
    s = contour.nearest(p)
    tangent = contour.tangent(s)
    outwards = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    return np.einsum("ij,ij->i", p - contour.point(s), outwards), outwards


def fit(contour: ClosedCurve, p: Array, *, turn: bool = True, iterations: int = 20) -> Fit:
    """Least-squares registration of points (N, 2) [m] on a contour, by Gauss-Newton.

    Args:
        turn: whether a rotation is allowed; a circle cannot tell one and gets none.
    """
    moved, angle = np.array(p, dtype=np.float64), 0.0
    for _ in range(iterations):
        distance, normal = _distance(contour, moved)
        lever = moved[:, 0] * normal[:, 1] - moved[:, 1] * normal[:, 0]
        J = np.column_stack([normal, lever]) if turn else normal
        step, *_ = np.linalg.lstsq(J, -distance, rcond=1e-6)
        turned = float(step[2]) if turn else 0.0
        c, s = np.cos(turned), np.sin(turned)
        moved = moved @ np.array([[c, s], [-s, c]]) + step[:2]
        angle += turned
        if np.abs(step).max() < CONVERGED:
            break
    c, s = np.cos(angle), np.sin(angle)
    shift = np.mean(p, axis=0) - np.mean(moved, axis=0) @ np.array([[c, -s], [s, c]])
    return Fit(points=moved, deviation=signed_distance(contour, moved), shift=shift, angle=angle)
