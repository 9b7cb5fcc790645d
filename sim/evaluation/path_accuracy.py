"""Path accuracy and repeatability after ISO 9283, of runs over a contour."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.measures.iso9283 import crossings, path_accuracy, path_repeatability

from .tool_error import ProgrammedContour, fit

POINTS = 100
"""Points along the contour."""


@dataclass(frozen=True, kw_only=True)
class PathMeasures:
    """Path accuracy and repeatability of n runs; NaN where samples are missing."""

    accuracy: float
    accuracy_in_plane: float
    """AT_p [m], with and without the height over the plane."""
    repeatability: float
    repeatability_in_plane: float
    """RT_p [m], likewise; NaN for a single run."""


def path_measures(motion: ProgrammedContour, runs: Sequence[tuple[Array, Array]]) -> PathMeasures:
    """Path accuracy and repeatability of runs over the contour of `motion`; see `attained`."""
    wanted, reached = commanded(motion), attained(motion, runs)
    several = len(runs) > 1
    return PathMeasures(
        accuracy=path_accuracy(wanted, reached),
        accuracy_in_plane=path_accuracy(wanted[:, :2], reached[..., :2]),
        repeatability=path_repeatability(reached) if several else np.nan,
        repeatability_in_plane=path_repeatability(reached[..., :2]) if several else np.nan,
    )


def commanded(motion: ProgrammedContour) -> Array:
    """Commanded points (M, 3) [m] of the contour in its plane: x, y and a height of zero."""
    curve = motion.curve
    return _flat(curve.point(_arc_length(curve.length)))


def attained(motion: ProgrammedContour, runs: Sequence[tuple[Array, Array]]) -> Array:
    """Attained points (n, M, 3) [m]: each run at the normal planes of the commanded points.

    All runs are moved by one rigid motion in the plane, which fits all of them together to the
    contour, and by their mean height: differences between runs stay. All NaN where a sample of the
    contour is missing.

    Args:
        runs: for each run (K,) time [s] and (K, 3) position [m] in base axes.
    """
    curve = motion.curve
    turns = [motion.plane.from_base(p[motion.is_on_contour(time)]) for time, p in runs]
    stacked, points = np.concatenate(turns), commanded(motion)
    if len(stacked) < 3 * len(turns) or not np.isfinite(stacked).all():
        return np.full((len(turns), *points.shape), np.nan)
    moved = stacked - stacked.mean(axis=0)
    moved[:, :2] = fit(curve, moved[:, :2]).points
    tangent = _flat(curve.tangent(_arc_length(curve.length)))
    each = np.split(moved, np.cumsum([len(turn) for turn in turns])[:-1])
    return np.array([crossings(points, tangent, run) for run in each])


def _arc_length(length: float) -> Array:
    # Away from the seam between the end of the contour and its start.
    return (np.arange(POINTS) + 0.5) * length / POINTS


def _flat(p: Array) -> Array:
    return np.column_stack([p, np.zeros(len(p))])
