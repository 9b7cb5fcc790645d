"""Corrections carried over from one motion to another along the same path."""

import numpy as np

from armside.arrays import Array
from armside.ilc.workbench.task import along_path

from ..motion.tool_motion import ToolMotion
from .motion import PartMotion

Motion = ToolMotion | PartMotion
SAME = 1e-9
"""[m], rounding of two plans of the same path."""


def place(motion: Motion) -> Array:
    """(N,) [m], arc length. Leads that are longer at a higher speed go on along the contour."""
    return motion.arc_length


def carried(correction: Array, before: Motion, motion: Motion, *, anywhere: bool = False) -> Array:
    """The correction (N, n) that was learned along `before`, for `motion`: (M, n).

    The same samples where both are timed alike, otherwise by the place on the path.
    anywhere: the path may lie elsewhere, as that of another robot does.

    Raises ValueError where they follow different paths.
    """
    if not follows(before, motion, anywhere=anywhere):
        which = "contour" if anywhere else "tool path"
        raise ValueError(f"its {which} is another one, and a correction belongs to its path")
    if len(correction) == len(motion.time) and np.array_equal(before.position, motion.position):
        return correction
    return along_path(correction, place(before), place(motion))


def follows(before: Motion, motion: Motion, *, anywhere: bool = False) -> bool:
    """Whether two motions follow the same path with the same orientation of the tool.

    anywhere: the same contours, wherever they lie.
    """
    if isinstance(before, PartMotion) and isinstance(motion, PartMotion):
        pairs = [(a.path, b.path) for a, b in zip(before.legs, motion.legs, strict=False)]
        same = len(before.legs) == len(motion.legs) and all(
            a.points.shape == b.points.shape and np.allclose(a.points, b.points, rtol=0, atol=SAME)
            for a, b in pairs
        )
    elif isinstance(before, ToolMotion) and isinstance(motion, ToolMotion):
        length = before.curve.length
        s = np.linspace(0.0, length, 500, endpoint=False)
        same = abs(length - motion.curve.length) < SAME and np.allclose(
            before.curve.point(s), motion.curve.point(s), rtol=0, atol=SAME
        )
    else:
        return False
    if anywhere:
        return bool(same)
    planes = (m.plane.origin for m in (before, motion)), (m.plane.axes for m in (before, motion))
    alike = all(np.allclose(*pair, rtol=0, atol=SAME) for pair in planes)
    return bool(same and alike and np.allclose(before.quaternion[0], motion.quaternion[0]))
