"""Errors of one contour of a part: its shape after a best fit, its corners, and its place."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..motion.contour import Circle
from ..part.curve import ChainCurve
from ..part.motion import ContourPlace, PartMotion
from .kerf import kerf
from .tool_error import ToolError, path_measures, signed_distance, tool_error

LARGEST_RADIUS = 20e-3
"""Radius up to which a bend is a corner [m]."""
BEYOND = 5e-3
"""Length behind a corner in which its overshoot belongs to it [m]."""
REST = 0.1
"""Time over which the position at rest before the part is averaged [s]."""


def corner_error(curve: ChainCurve, path: Array) -> float:
    """Largest deviation of a path (N, 2) [m] in the corners of a contour; NaN without corners.

    Each corner counts with the first millimetres behind it, as the cornering overshoot of ISO 9283
    does. The path runs as the contour does.
    """
    here = in_corners(curve, curve.nearest(path))
    return float(np.abs(signed_distance(curve, path[here])).max()) if here.any() else np.nan


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


@dataclass(frozen=True, kw_only=True)
class ContourError(ToolError):
    """Errors of one contour in one run [m]; NaN where samples are missing."""

    position: float
    """Distance of its middle from its programmed place, counted from the tool at rest."""
    path_accuracy: float
    """AT_p after ISO 9283."""
    roundness: float
    """Of the edge of a round hole that a beam leaves; NaN for any other contour."""
    corner: float
    """Largest deviation of the shape in corners; NaN where there are none."""


def contour_errors(
    motion: PartMotion, time: Array, position: Array, beam: float | None = None
) -> tuple[ContourError, ...]:
    """Errors of all contours in their order.

    time, position: (K,) [s] and (K, 3) [m], base axes. beam: diameter [m]; None for no roundness
    and no corners.
    """
    at_rest = time < REST
    programmed = motion.position_at(time[:1])[0]
    from_rest = position - (position[at_rest].mean(axis=0) - programmed)
    bounds = np.searchsorted(time, [place.contour_time for place in motion.places])
    return tuple(
        _error(place, time[first:last], from_rest[first:last], beam)
        for place, (first, last) in zip(motion.places, bounds, strict=True)
    )


def _error(place: ContourPlace, time: Array, position: Array, beam: float | None) -> ContourError:
    shape, curve = tool_error(place, time, position), place.curve
    in_plane = place.plane.from_base(position)[:, :2]
    roundness = corner = offset = np.nan
    if beam is not None and isinstance(curve, Circle):
        roundness = kerf(curve, shape.path, beam).roundness
    if beam is not None and isinstance(curve, ChainCurve):
        corner = corner_error(curve, shape.path)
    if len(in_plane) == len(shape.path) > 0:  # the best fit has moved it by that
        offset = float(np.linalg.norm((in_plane - shape.path).mean(axis=0)))
    return ContourError(
        rms=shape.rms,
        maxdev=shape.maxdev,
        position=offset,
        path_accuracy=path_measures(place, [(time, position)]).accuracy,
        roundness=roundness,
        corner=corner,
        path=shape.path,
    )
