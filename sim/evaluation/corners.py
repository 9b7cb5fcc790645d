"""Deviation of a path in the corners of its contour."""

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..part.curve import ChainCurve
from .tool_error import signed_distance

LARGEST_RADIUS = 20e-3
"""Radius up to which a bend is a corner [m]."""
BEYOND = 5e-3
"""Length behind a corner in which its overshoot belongs to it [m]."""


def corner_error(curve: ChainCurve, path: Array) -> float:
    """Largest deviation of a path (N, 2) [m] in the corners of a contour; NaN without corners.

    Each corner counts with the first millimetres behind it, as the cornering overshoot of ISO 9283
    does. The path runs as the contour does.
    """
    at = curve.nearest(path)
    here = in_corners(curve, at)
    if not here.any():
        return np.nan
    return float(np.abs(signed_distance(curve, path[here])).max())


def in_corners(curve: ChainCurve, s: Array) -> NDArray[np.bool_]:
    """Mask of the arc lengths s (N,) [m] in a corner or just behind one."""
    chain = curve.chain
    bends = np.abs(chain.curvature) * LARGEST_RADIUS >= 1.0
    ends = chain.ends[1:][bends]
    if not len(ends):
        return np.zeros(len(s), dtype=np.bool_)
    inside = np.abs(chain.curvature_at(s)) * LARGEST_RADIUS >= 1.0
    passed = np.searchsorted(ends, s, side="right") - 1
    behind = s - ends[passed]
    if chain.closed:
        behind = np.mod(behind, chain.length)
    return np.asarray(inside | ((behind >= 0.0) & (behind <= BEYOND)))
