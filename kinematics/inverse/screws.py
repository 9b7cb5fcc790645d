"""Joint axes of a robot at joint variables 0 as lines in base axes, for geometric closed forms.

T(q) = e^(S_1 q_1) ... e^(S_n q_n) T(0), where S_i is a rotation about line i, or a translation
along it. Three revolute axes that meet have their angles from a rotation.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..dh import Robot
from ..rigid import link_transform, standard_links
from ..rotation import from_axis_angle
from .closed_form import Branches
from .six_axes import require

ALIGNED = 1e-10
"""Sine between the first and the third axis below which the first angle is free."""


def three_axes(M: Array, u: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Both solutions of R(u_1, q_1) R(u_2, q_2) R(u_3, q_3) = M.

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


SQUARE = 1e-10
"""Cosine, or distance [m], below which axes count as at right angles, or as meeting."""


@dataclass(frozen=True)
class Screws:
    """Unit directions (n, 3), points (n, 3) of the axes, and T_base_tool (4, 4), all at zero."""

    direction: Array
    point: Array
    tool: Array


def screws(robot: Robot, kinds: str) -> Screws:
    """Axes of a robot whose joints are of the given kinds, "RRP" and so on.

    Raises UnsolvableGeometryError: it has symbols, or other joints.
    """
    require(not robot.free_symbols, robot, "has symbolic parameters")
    given = "".join("P" if slides else "R" for slides in robot.slides)
    require(given == kinds, robot, f"its joints are {given}, not {kinds}")
    T, directions, points = np.eye(4), [], []
    for link in standard_links(robot):
        if link.moves:
            directions.append(T[:3, 2])
            points.append(T[:3, 3])
        T = T @ link_transform(link)
    return Screws(np.array(directions), np.array(points), T)


def require_square(robot: Robot, axes: Screws, one: int, other: int) -> None:
    """Refuse a robot two of whose axes, counted from 1, are not at right angles."""
    cosine = float(axes.direction[one - 1] @ axes.direction[other - 1])
    complaint = f"axes {one} and {other} are not at right angles, their cosine is {cosine:.3g}"
    require(abs(cosine) < SQUARE, robot, complaint)


def meeting_point(robot: Robot, axes: Screws, first: int) -> Array:
    """Point (3,) where three axes in a row meet, from the first, counted from 1.

    Raises UnsolvableGeometryError: they do not meet.
    """
    three = range(first - 1, first + 2)
    planes = [np.eye(3) - np.outer(axes.direction[i], axes.direction[i]) for i in three]
    right = np.concatenate([P @ axes.point[i] for P, i in zip(planes, three, strict=True)])
    point = np.linalg.lstsq(np.concatenate(planes), right)[0]
    gap = float(np.abs(np.concatenate(planes) @ point - right).max())
    complaint = f"axes {first}, {first + 1} and {first + 2} do not meet, they are {gap:.3g} m apart"
    require(gap < SQUARE, robot, complaint)
    return np.asarray(point, dtype=np.float64)


def branches_of(
    robot: Robot, q: Array, exists: NDArray[np.bool_], singular: Any, single: bool
) -> Branches:
    """Motor angles of joint variables q (N, b, n), revolute joints within half a turn of phi = 0.

    exists and singular: (N, b); NaN where a branch does not exist.
    """
    turns = np.where(robot.slides, 0.0, np.round((q - robot.offset) / (2 * np.pi)))
    phi = robot.motor_angles(np.nan_to_num(q) - 2 * np.pi * np.nan_to_num(turns))
    phi[~exists] = np.nan
    flags = np.where(exists, singular, 0).astype(np.int8)
    return Branches(phi[0], exists[0], flags[0]) if single else Branches(phi, exists, flags)
