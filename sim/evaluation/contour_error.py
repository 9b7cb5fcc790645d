"""Errors of one contour of a part: its shape after a best fit, and its place."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..cut.contour import Circle
from ..part.curve import ChainCurve
from ..part.motion import ContourPlace, PartMotion
from .corners import corner_error
from .kerf import kerf
from .path_accuracy import path_measures
from .tool_error import ToolError, tool_error

REST = 0.1
"""Time over which the position at rest before the part is averaged [s]."""


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
    resting = time < REST
    programmed = motion.position_at(time[:1])[0]
    from_rest = position - (position[resting].mean(axis=0) - programmed)
    bounds = np.searchsorted(time, [place.contour_time for place in motion.places])
    return tuple(
        _error(place, time[first:last], from_rest[first:last], beam)
        for place, (first, last) in zip(motion.places, bounds, strict=True)
    )


def _error(place: ContourPlace, time: Array, position: Array, beam: float | None) -> ContourError:
    shape = tool_error(place, time, position)
    round_edge = corner = np.nan
    if beam is not None and isinstance(place.curve, Circle):
        round_edge = kerf(place.curve, shape.path, beam).roundness
    if beam is not None and isinstance(place.curve, ChainCurve):
        corner = corner_error(place.curve, shape.path)
    return ContourError(
        rms=shape.rms,
        maxdev=shape.maxdev,
        position=_offset(place, position, shape.path),
        path_accuracy=path_measures(place, [(time, position)]).accuracy,
        roundness=round_edge,
        corner=corner,
        path=shape.path,
    )


def _offset(place: ContourPlace, position: Array, fitted: Array) -> float:
    """Distance of the middle of a contour from its place [m]: what the best fit has moved it by."""
    in_plane = place.plane.from_base(position)[:, :2]
    if len(in_plane) != len(fitted) or not len(fitted):
        return np.nan
    return float(np.linalg.norm((in_plane - fitted).mean(axis=0)))
