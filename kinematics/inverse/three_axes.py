"""Angles of three revolute axes that meet, each at right angles to the next, from a rotation."""

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..rotation import from_axis_angle

ALIGNED = 1e-10
"""Sine between the first and the third axis below which the first angle is free."""


def three_axes(M: Array, u: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Both solutions of R(u_1, q_1) R(u_2, q_2) R(u_3, q_3) = M.

    Args:
        M: rotations (N, 3, 3).
        u: directions (3, 3) of the axes at zero, in rows; u_2 is at right angles to the others.

    Returns q (N, 2, 3) [rad], and aligned (N,): only q_1 +- q_3 is determined, and q_1 is 0.
    """
    u1, u2, u3 = u
    e = np.cross(u2, u1)
    f = np.cross(u1, e)
    gamma = np.arctan2(u3 @ e, u3 @ u1)
    w = M @ u3
    along, across, beside = w @ u1, w @ e, w @ f
    sine = np.hypot(across, beside)
    aligned = sine < ALIGNED
    q = np.empty((len(M), 2, 3))
    for branch, sign in enumerate((1.0, -1.0)):
        first = np.where(aligned, 0.0, np.arctan2(sign * beside, sign * across))
        second = sign * np.arctan2(sine, along) - gamma
        back = from_axis_angle(u2, -second) @ from_axis_angle(u1, -first) @ M
        turned = back @ u2
        third = np.arctan2(np.cross(u2, turned) @ u3, turned @ u2)
        q[:, branch] = np.stack([first, second, third], axis=-1)
    return q, aligned
