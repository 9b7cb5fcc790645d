"""Tool error: distance of the tool's path from the programmed contour, after a best fit.

A circle is moved to its least-squares centre, as thesis 9.3 does, or to its mean where it is too
flat for one; any other contour is moved and rotated onto the programmed one. Path accuracy and
repeatability after ISO 9283 are those of several runs, fitted together.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array
from armside.ilc.measures import norms as measures
from armside.ilc.measures.iso9283 import crossings, path_accuracy, path_repeatability

from ..motion.contour import Circle, ClosedCurve, outward_normal
from ..motion.path import Plane

STEPS = 20
"""Most steps of a fit."""
CONVERGED = 1e-12
"""[m] and [rad]: largest last step of a fit."""
INSIDE = 0.5
"""Radii by which the least-squares centre may lie off the path's mean. A turn that is flattened
more is better explained by a short arc of a huge circle than by a whole circle."""
PLACES = 100
"""Points along the contour."""


@dataclass(frozen=True, kw_only=True)
class ToolError:
    """Error of the tool on one turn of the contour."""

    rms: float
    maxdev: float
    """[m], (9.6) and (9.7)."""
    path: Array
    """(M, 2) [m], the measured contour in its plane, fitted to the programmed one."""


class ProgrammedContour(Protocol):
    """A contour in its plane, and the times at which it is cut."""

    @property
    def plane(self) -> Plane: ...
    @property
    def curve(self) -> ClosedCurve: ...
    def is_on_contour(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Mask of the times [s] on the contour."""
        ...


def tool_error(motion: ProgrammedContour, time: Array, position: Array) -> ToolError:
    """Error of the tool on one turn of the contour, (9.6) and (9.7).

    On a contour that is no circle, the distance from it takes the place of r_ref - r_meas. Where
    samples are missing, rms and maxdev are NaN and the path has the samples that exist.

    position: (K, 3) [m] at the times (K,) [s], base axes; NaN where there is no sample.
    """
    turn = position[motion.is_on_contour(time)]
    points = motion.plane.from_base(turn)[:, :2]
    finite = np.isfinite(points)
    if len(turn) < 3 or not finite.all():
        seen = points[finite.all(axis=1)]
        centred = seen - seen.mean(axis=0) if len(seen) else seen
        return ToolError(rms=np.nan, maxdev=np.nan, path=centred)
    curve = motion.curve
    if isinstance(curve, Circle):
        path = points - _centre(points, curve.radius)
        deviation = curve.radius - np.hypot(path[:, 0], path[:, 1])
    else:
        path, deviation = fit(curve, points)
    rms, maxdev = float(np.sqrt(np.mean(deviation**2))), float(np.abs(deviation).max())
    return ToolError(rms=rms, maxdev=maxdev, path=path)


def _centre(points: Array, radius: float) -> Array:
    """Least-squares centre (2,) of one turn (M, 2), or the mean where that runs away from it."""
    mean = points.mean(axis=0)
    try:
        centre = measures.circle_centre(points)
    except ValueError:
        return mean
    return centre if np.hypot(*(centre - mean)) <= INSIDE * radius else mean


class Fit(NamedTuple):
    """Points in the plane of a contour after the rigid motion that fits them to it."""

    points: Array
    """(N, 2) [m], after the motion."""
    deviation: Array
    """(N,) [m], signed distance from the contour, above 0 outside."""


def fit(contour: ClosedCurve, p: Array) -> Fit:
    """Registration of points (N, 2) [m] on a contour, by Gauss-Newton; a circle is only moved."""
    rotate = not isinstance(contour, Circle)
    moved = np.array(p, dtype=np.float64)
    for _ in range(STEPS):
        distance, normal = _distance(contour, moved)
        lever = moved[:, 0] * normal[:, 1] - moved[:, 1] * normal[:, 0]
        J = np.column_stack([normal, lever]) if rotate else normal
        step, *_ = np.linalg.lstsq(J, -distance, rcond=1e-6)
        rotation = float(step[2]) if rotate else 0.0
        c, s = np.cos(rotation), np.sin(rotation)
        moved = moved @ np.array([[c, s], [-s, c]]) + step[:2]
        if np.abs(step).max() < CONVERGED:
            break
    return Fit(points=moved, deviation=signed_distance(contour, moved))


def signed_distance(contour: ClosedCurve, p: Array) -> Array:
    """(N,) [m], above 0 to the right of the contour: outside if it is counter-clockwise."""
    return _distance(contour, p)[0]


def _distance(contour: ClosedCurve, p: Array) -> tuple[Array, Array]:
    """Signed distance of each point, and the outward normal at its nearest contour point."""
    s = contour.nearest(p)
    outwards = outward_normal(contour.tangent(s))
    return np.einsum("ij,ij->i", p - contour.point(s), outwards), outwards


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
    return np.pad(motion.curve.point(_arc_length(motion.curve.length)), ((0, 0), (0, 1)))


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
    tangent = np.pad(curve.tangent(_arc_length(curve.length)), ((0, 0), (0, 1)))
    each = np.split(moved, np.cumsum([len(turn) for turn in turns])[:-1])
    return np.array([crossings(points, tangent, run) for run in each])


def _arc_length(length: float) -> Array:
    # Away from the seam between the end of the contour and its start.
    return (np.arange(PLACES) + 0.5) * length / PLACES
