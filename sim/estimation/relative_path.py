"""A tool's path as six columns: displacement and rotation vector from rest.

The position at rest, millimetres below the program under gravity, is not observable in a run and
does not affect a cut. So paths count from rest.
"""

import numpy as np

from armside.arrays import Array

REST_SAMPLES = 25
"""Over which the position at rest is averaged: 0.1 s of the motor log, before the arm moves."""


def relative_to_start(position: Array, quaternion: Array | None = None) -> Array:
    """(N, 6): displacement [m] and rotation vector [rad] from rest, base axes.

    position: (N, 3) [m]. quaternion: (N, 4) base to tool, w first; None for positions alone, with
    rotations of zero.
    """
    from scipy.spatial.transform import Rotation

    path = np.zeros((len(position), 6))
    path[:, :3] = position - position[:REST_SAMPLES].mean(axis=0)
    if quaternion is not None:
        R = Rotation.from_quat(quaternion, scalar_first=True)
        path[:, 3:] = (R * R[0].inv()).as_rotvec()
        path[:, 3:] -= path[:REST_SAMPLES, 3:].mean(axis=0)
    return path
