"""Tool error: distance of the tool's path from the programmed contour, after a best fit.

A circle is moved to its least-squares centre, as thesis 9.3 does, or to its mean where it is too
flat for one; any other contour is moved and rotated onto the programmed one.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array
from armside.ilc.measures import norms as measures

from ..cut.contour import Circle, ClosedCurve, outward_normal
from ..cut.path import Plane

CONVERGED = 1e-12
"""[m] and [rad]: largest last step of a fit."""
INSIDE = 0.5
"""Radii by which the least-squares centre may lie off the path's mean. A turn that is flattened
more is better explained by a short arc of a huge circle than by a whole circle."""


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
        fitted = fit(curve, points)
        path, deviation = fitted.points, fitted.deviation
    rms, maxdev = float(np.sqrt(np.mean(deviation**2))), float(np.abs(deviation).max())
    return ToolError(rms=rms, maxdev=maxdev, path=path)


def _centre(points: Array, radius: float) -> Array:
    """Least-squares centre (2,) of one turn, or the mean where that runs away from the path.

    points: (M, 2) [m], evenly around the turn. radius: programmed [m].
    """
    mean = points.mean(axis=0)
    try:
        centre = measures.circle_centre(points)
    except ValueError:
        return mean
    return centre if np.hypot(*(centre - mean)) <= INSIDE * radius else mean


@dataclass(frozen=True, kw_only=True)
class Fit:
    """Points in the plane of a contour after the rigid motion that fits them to it."""

    points: Array
    """(N, 2) [m], after the motion."""
    deviation: Array
    """(N,) [m], signed distance from the contour, above 0 outside."""


def fit(contour: ClosedCurve, p: Array, iterations: int = 20) -> Fit:
    """Least-squares registration of points (N, 2) [m] on a contour, by Gauss-Newton.

    The rotation of a circle is undetermined: it is only moved.
    """
    rotate = not isinstance(contour, Circle)
    moved = np.array(p, dtype=np.float64)
    for _ in range(iterations):
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
