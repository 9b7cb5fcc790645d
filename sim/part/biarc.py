"""Smooth curves as chains of arcs that join smoothly, within a tolerance."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from armside.arrays import Array

from .chain import Chain, joined

TOLERANCE = 1e-6
"""Largest distance between a curve and its arcs [m]."""
DEEPEST = 16
"""Most times a curve is halved."""
CHECKS = np.linspace(0.0, 1.0, 9)[1:-1]

PointAndTangent = Callable[[float], tuple[Array, Array]]
"""Point (2,) [m] and tangent (2,), of any length, at a parameter."""


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


def fitted(
    curve: PointAndTangent, breaks: Array | list[float], tolerance: float = TOLERANCE
) -> Chain:
    """Arcs along a curve that is smooth between `breaks`, increasing parameters.

    Raises ValueError for a curve that arcs do not come near.
    """
    pieces = [
        _fitted(curve, float(lower), float(upper), tolerance, DEEPEST)
        for lower, upper in pairwise(breaks)
    ]
    return joined(pieces)


def _fitted(
    curve: PointAndTangent, lower: float, upper: float, tolerance: float, deeper: int
) -> Chain:
    (p, along_p), (q, along_q) = _unit(curve, lower, upper), _unit(curve, upper, lower)
    arcs = biarc(p, along_p, q, along_q)
    between = np.array([curve(lower + (upper - lower) * x)[0] for x in CHECKS])
    if np.abs(arcs.angle).max() < np.pi / 3 and _off(arcs, between) <= tolerance:
        return arcs
    if deeper == 0:
        raise ValueError("the curve has a cusp or is not smooth")
    middle = 0.5 * (lower + upper)
    return joined(
        [
            _fitted(curve, lower, middle, tolerance, deeper - 1),
            _fitted(curve, middle, upper, tolerance, deeper - 1),
        ]
    )


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
    distance = []
    for i, bend in enumerate(arcs.curvature):
        heading = arcs.heading[i]
        normal = np.array([-np.sin(heading), np.cos(heading)])
        offset = points - arcs.points[i]
        # (|offset - normal / k| - 1 / k), without the difference of two large numbers
        square = bend * np.sum(offset**2, axis=1) - 2.0 * offset @ normal
        distance.append(np.abs(square) / (1.0 + np.sqrt(np.maximum(1.0 + bend * square, 0.0))))
    return float(np.min(distance, axis=0).max())


def _angle(a: Array, b: Array) -> float:
    """From a to b [rad], in (-pi, pi]."""
    return float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
