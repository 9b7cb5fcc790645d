"""How true the tool's contour was: its distance from the programmed one, after the best fit."""

from dataclasses import dataclass

import numpy as np

from ilc import measures

from .motion.deviation import fit
from .motion.path import Circle
from .motion.program import ToolMotion
from .recording import Array


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
    seen = turn[np.isfinite(turn).all(axis=1)]
    curve, axes = motion.path.curve, motion.plane.axes
    if len(seen) < max(3, len(turn)):
        return ArmSide(rms=np.nan, maxdev=np.nan, path=(seen - seen.mean(axis=0)) @ axes[:, :2])
    if isinstance(curve, Circle):
        circle = measures.fit_circle(turn, normal=axes[:, 2])
        return ArmSide(
            rms=measures.circle_rms(circle.radii, curve.radius),
            maxdev=measures.circle_maxdev(circle.radii, curve.radius),
            path=(turn - circle.centre) @ axes[:, :2],
        )
    fitted = fit(curve, motion.plane.from_base(turn)[:, :2])
    return ArmSide(
        rms=float(np.sqrt(np.mean(fitted.deviation**2))),
        maxdev=float(np.abs(fitted.deviation).max()),
        path=fitted.points,
    )
