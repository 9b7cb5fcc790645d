"""How true the tool's contour was: its distance from the programmed one, after the best fit."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures

from ..cut.deviation import fit
from ..cut.path import Circle
from ..cut.tool_motion import ToolMotion


@dataclass(frozen=True, kw_only=True)
class ArmSide:
    """How true the tool's contour was, as thesis 9.3 measures it for a circle."""

    rms: float
    """[m], (9.6)."""
    maxdev: float
    """[m], (9.7)."""
    path: Array
    """(M, 2) [m], the contour in its plane, moved onto the programmed one: a circle to its own
    least-squares centre."""


def arm_side(motion: ToolMotion, time: Array, position: Array) -> ArmSide:
    """Measures of one turn of the contour.

    A circle is moved to its least-squares centre, (9.6) and (9.7); any other contour is moved and
    turned onto the programmed one, and its distance from it takes the place of r_ref - r_meas.
    A turn with samples missing has no measure: rms and maxdev are NaN, the path is what is left.

    Args:
        time: (K,) [s].
        position: (K, 3) [m], base axes; NaN where there is no sample.
    """
    turn = position[motion.is_on_contour(time)]
    points = motion.plane.from_base(turn)[:, :2]
    whole = np.isfinite(points)
    if len(turn) < 3 or not whole.all():
        seen = points[whole.all(axis=1)]
        return ArmSide(rms=np.nan, maxdev=np.nan, path=seen - seen.mean(axis=0))
    curve = motion.path.curve
    if isinstance(curve, Circle):
        path = points - measures.circle_centre(points)
        deviation = curve.radius - np.hypot(path[:, 0], path[:, 1])
    else:
        fitted = fit(curve, points)
        path, deviation = fitted.points, fitted.deviation
    return ArmSide(
        rms=float(np.sqrt(np.mean(deviation**2))),
        maxdev=float(np.abs(deviation).max()),
        path=path,
    )
