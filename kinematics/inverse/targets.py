"""Poses that inverse kinematics is asked for: their checks, and the cause of a path's end."""

from enum import Enum
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, real_array

from ..dh import Limits, Robot
from ..rigid import ORTHOGONAL


def batch(T: ArrayLike) -> tuple[Array, bool]:
    """Targets (N, 4, 4), and True for a single one. Raises ValueError for other than poses."""
    T = real_array("T", T)
    if T.ndim not in (2, 3) or T.shape[-2:] != (4, 4):
        raise ValueError(f"T must have shape (4, 4) or (N, 4, 4), got {T.shape}")
    R = T[..., :3, :3]
    if not (
        np.isfinite(T).all()
        and np.allclose(np.swapaxes(R, -1, -2) @ R, np.eye(3), rtol=0, atol=ORTHOGONAL)
        and (np.linalg.det(R) > 0).all()
        and (T[..., 3, :] == [0, 0, 0, 1]).all()
    ):
        refuse_motion(T)
    return T.reshape(-1, 4, 4), T.ndim == 2


def refuse_motion(T: Array) -> NoReturn:
    """Raise what is wrong with poses that are not rigid motions."""
    if not np.isfinite(T).all():
        raise ValueError("T must be finite; it contains NaN or infinity")
    raise ValueError("T must be rigid motions: a rotation, a position and a row 0 0 0 1")


class Cause(Enum):
    """Cause of a target that is not solved from the one before it."""

    LIMIT = "joint limit"
    SINGULARITY = "singularity"
    REACH = "reach"


def limit_passed(phi: Array, limits: Limits, slack: float = 0.0) -> str | None:
    """The range that phi is furthest beyond, in words; None if it is in all.

    phi: (n,), or (k, n) configurations, of which the one that is least beyond its ranges counts.
    """
    phi = np.atleast_2d(phi)
    words = [f"motor {i} would be at" for i in range(1, phi.shape[1] + 1)]
    values, lower, upper = list(phi.T), list(limits.lower), list(limits.upper)
    for bound in limits.coupled:
        terms = [f"{k:+g} phi_{i}" for i, k in enumerate(bound.coefficients, 1) if k]
        words.append(f"{' '.join(terms)} would be")
        values.append(phi @ np.asarray(bound.coefficients))
        lower.append(bound.lower)
        upper.append(bound.upper)
    at = np.transpose(values)
    beyond = np.maximum(at - upper, lower - at)
    least = int(np.argmin(beyond.max(axis=1)))
    worst = int(np.argmax(beyond[least]))
    if beyond[least, worst] <= slack:
        return None
    low, high = lower[worst], upper[worst]
    return f"{words[worst]} {at[least, worst]:.4f}, and its range is {low:.4f} to {high:.4f}"


def joint_jump(robot: Robot, before: Array, phi: Array) -> str:
    """The revolute joint that turns most between two configurations (n,), in words."""
    turn = np.abs(robot.coupling @ (phi - before))
    turn *= ~np.array(robot.slides)
    joint = int(np.argmax(turn))
    return f"joint {joint + 1} would turn by {np.degrees(turn[joint]):.0f} deg in one step"
