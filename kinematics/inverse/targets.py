"""Poses that inverse kinematics is asked for: their checks, and the cause of a path's end."""

from enum import Enum
from typing import NoReturn

import numpy as np

from armside.arrays import Array

from ..dh import Joint, Limits, Robot
from ..rigid import ORTHOGONAL


def check_rigid(T: Array) -> None:
    """Refuse poses (..., 4, 4) that are not rigid motions."""
    R = T[..., :3, :3]
    if not (
        np.isfinite(T).all()
        and np.allclose(np.swapaxes(R, -1, -2) @ R, np.eye(3), rtol=0, atol=ORTHOGONAL)
        and (np.linalg.det(R) > 0).all()
        and (T[..., 3, :] == [0, 0, 0, 1]).all()
    ):
        refuse_motion(T)


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
    """The range that phi (n,) is furthest beyond, in words; None if it is in all."""
    words = [f"motor {i} would be at" for i in range(1, len(phi) + 1)]
    values, lower, upper = list(phi), list(limits.lower), list(limits.upper)
    for bound in limits.coupled:
        terms = [f"{k:+g} phi_{i}" for i, k in enumerate(bound.coefficients, 1) if k]
        words.append(f"{' '.join(terms)} would be")
        values.append(float(phi @ np.asarray(bound.coefficients)))
        lower.append(bound.lower)
        upper.append(bound.upper)
    beyond = np.maximum(np.subtract(values, upper), np.subtract(lower, values))
    worst = int(np.argmax(beyond))
    if beyond[worst] <= slack:
        return None
    at, low, high = values[worst], lower[worst], upper[worst]
    return f"{words[worst]} {at:.4f}, and its range is {low:.4f} to {high:.4f}"


def least_passed(phi: Array, limits: Limits) -> str:
    """The range that the best of configurations phi (k, n), all beyond the limits, is beyond."""
    ends = np.maximum(phi - np.asarray(limits.upper), np.asarray(limits.lower) - phi)
    beyond = ends.max(axis=1)
    for bound in limits.coupled:
        value = phi @ np.asarray(bound.coefficients)
        beyond = np.maximum(beyond, np.maximum(value - bound.upper, bound.lower - value))
    return str(limit_passed(phi[int(np.argmin(beyond))], limits))


def joint_jump(robot: Robot, before: Array, phi: Array) -> str:
    """The revolute joint that turns most between two configurations (n,), in words."""
    turn = np.abs(robot.coupling @ (phi - before))
    turn *= [robot.links[i].joint is Joint.REVOLUTE for i in robot.moving]
    joint = int(np.argmax(turn))
    return f"joint {joint + 1} would turn by {np.degrees(turn[joint]):.0f} deg in one step"
