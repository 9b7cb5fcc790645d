"""A cut contour after the rigid motion that fits it to its drawing, and what that took off.

A contour that lies a fraction of a millimetre beside its place has deviations that are not linear
in it. Two such contours are compared after each is fitted; what their motions differ by is linear.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..evaluation.tool_error import fit
from ..motion.contour import ClosedCurve, outward_normal
from .reading import ScannedContour

HELD = 0.4e-3
"""[m], of both ends of a contour, that two passes of the beam have swept, or none."""
_GAP = 0.5e-3
"""[m], between readings, within which a scan says nothing."""
LARGEST = 1e-3
"""[m], RMS of the deviation after the fit: that of a tool is a fifth of it. ESTIMATE."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A contour as cut, about its drawn middle: what is left after a rigid motion, and that."""

    arc_length: Array
    deviation: Array
    """(M,) [m], after the motion."""
    motion: Array
    """(3,), x, y [m] and angle [rad] that the motion has taken off."""

    @property
    def rms(self) -> float:
        """Of the deviation [m]."""
        return float(np.sqrt(np.mean(self.deviation**2)))

    @property
    def objection(self) -> str | None:
        """Why it cannot be that of the drawing; None if it can."""
        if self.rms <= LARGEST:
            return None
        return (
            f"the scanned contour is {1e3 * self.rms:.3g} mm RMS from its drawing after placement, "
            f"more than {1e3 * LARGEST:g} mm"
        )

    def at(self, s: Array, length: float) -> Array:
        """Deviation at arc lengths (K,) of a contour of that length."""
        return np.asarray(np.interp(s, self.arc_length, self.deviation, period=length))


def shape(curve: ClosedCurve, points: Array) -> Shape:
    """Of points (M, 2) [m] along a contour, about its drawn middle."""
    found = fit(curve, points)
    p, mean = found.points, points.mean(axis=0)
    a, b = p - p.mean(axis=0), points - mean
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), np.vdot(a, b))
    c, s = np.cos(angle), np.sin(angle)
    shift = mean - np.array([[c, -s], [s, c]]) @ p.mean(axis=0)
    return Shape(curve.nearest(p), found.deviation, np.array([*shift, angle]))


def taken_off(curve: ClosedCurve, s: Array) -> Array:
    """(M, 3), deviation by a motion (x, y, angle) about the middle of the contour."""
    p, n = curve.point(s), outward_normal(curve.tangent(s))
    return np.column_stack([n, p[:, 0] * n[:, 1] - p[:, 1] * n[:, 0]])


def scanned_shape(curve: ClosedCurve, seen: ScannedContour) -> Shape:
    """Of a contour as scanned."""
    normal = outward_normal(curve.tangent(seen.arc_length))
    return shape(curve, curve.point(seen.arc_length) + seen.deviation[:, None] * normal)


def usable(curve: ClosedCurve, scanned: Shape, foot: Array) -> NDArray[np.bool_]:
    """(K,) of the feet of a path [m] from its first to its last on the contour: those that the
    scan has seen, its ends left out."""
    length, seen = curve.length, np.sort(scanned.arc_length)
    from_ends = np.abs((foot[:, None] - foot[[0, -1]] + 0.5 * length) % length - 0.5 * length)
    after = np.clip(np.searchsorted(seen, foot), 1, len(seen) - 1)
    near = (seen[after] - seen[after - 1] < _GAP) & (foot > seen[0]) & (foot < seen[-1])
    return np.asarray((from_ends > HELD).all(axis=1) & near)
