"""Corrections carried over from one motion to another along the same path."""

import numpy as np

from armside.arrays import Array
from armside.ilc.workbench.task import along_path

from ..motion.tool_motion import ToolMotion
from .motion import PartMotion

Motion = ToolMotion | PartMotion
SAME = 1e-9
"""[m], rounding of two plans of the same path."""


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
    # Leads that are longer at a higher speed go on along the contour.
    return along_path(correction, before.arc_length, motion.arc_length)


def follows(before: Motion, motion: Motion, *, anywhere: bool = False) -> bool:
    """Whether two motions follow the same path with the same orientation of the tool.

    anywhere: the same contours, wherever they lie.
    """
    pairs = list(zip(before.outline, motion.outline, strict=False))
    same = len(before.outline) == len(motion.outline) and all(
        a.shape == b.shape and np.allclose(a, b, rtol=0, atol=SAME) for a, b in pairs
    )
    if anywhere:
        return bool(same)
    planes = (m.plane.origin for m in (before, motion)), (m.plane.axes for m in (before, motion))
    alike = all(np.allclose(*pair, rtol=0, atol=SAME) for pair in planes)
    return bool(same and alike and np.allclose(before.quaternion[0], motion.quaternion[0]))
