"""First estimate of base frame, targets and tool rotation for the nominal robot.

The frame of the instrument, p_frame = R p_base + p, and the targets t in the tool frame are found
in turns: each is a linear or a Procrustes problem when the other is known.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from .measurements import Measurements

TURNS = 200
"""Most alternations; they converge by a factor of about the tool's part of the reach."""
SETTLED = 1e-7
"""[m] Change of the targets at which the alternation ends."""


class Registration(NamedTuple):
    """Frames of the nominal robot: p_frame = R (pose(phi) t) + p."""

    R: Array
    """(3, 3), base to the frame of the instrument."""
    p: Array
    """(3,) [m]."""
    targets: Array
    """(T, 3) [m], in the tool frame of the robot."""
    R_tool: Array
    """(3, 3), measured tool frame in that of the robot; the identity where none was measured."""


def register(T_base_tool: Array, data: Measurements) -> Registration:
    """Registration of nominal poses (N, 4, 4) with what was measured, by least squares."""
    R_tool, p_tool = T_base_tool[:, :3, :3], T_base_tool[:, :3, 3]
    seen = np.asarray(np.isfinite(data.points).all(axis=2))
    targets = np.zeros((data.n_targets, 3))
    R, p = np.eye(3), np.zeros(3)
    for _ in range(TURNS):
        nominal = p_tool[:, None] + np.einsum("nij,tj->nti", R_tool, targets)
        R, p = procrustes(nominal[seen], data.points[seen])
        before, targets = targets, _targets(R_tool, p_tool, (data.points - p) @ R, seen)
        if np.abs(targets - before).max() < SETTLED:
            break
    return Registration(R, p, targets, _tool_rotation(R_tool, R, data))


def procrustes(source: Array, goal: Array) -> tuple[Array, Array]:
    """Rotation R and translation p of least squares, goal = R source + p; points (N, 3)."""
    a, b = source.mean(axis=0), goal.mean(axis=0)
    u, _, vt = np.linalg.svd((goal - b).T @ (source - a))
    R = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return R, b - R @ a


def _targets(R_tool: Array, p_tool: Array, in_base: Array, seen: NDArray[np.bool_]) -> Array:
    """Mean of each target in the tool frame."""
    local = np.einsum("nji,ntj->nti", R_tool, in_base - p_tool[:, None])
    return np.stack([local[seen[:, t], t].mean(axis=0) for t in range(local.shape[1])])


def _tool_rotation(R_tool: Array, R: Array, data: Measurements) -> Array:
    from scipy.spatial.transform import Rotation

    if data.rotation is None:
        return np.eye(3)
    measured = np.swapaxes(R_tool, 1, 2) @ R.T @ data.rotation
    return Rotation.from_matrix(measured).mean().as_matrix()
