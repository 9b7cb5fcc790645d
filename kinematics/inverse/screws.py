"""Joint axes of a robot at joint variables 0 as lines in base axes, for geometric closed forms.

T(q) = e^(S_1 q_1) ... e^(S_n q_n) T(0), where S_i is a rotation about line i, or a translation
along it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ..arguments import real_array
from ..dh import Joint, Robot
from ..links import link_transform, standard_links
from .closed_form import Branches
from .six_axes import require
from .targets import check_rigid

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

    Raises:
        UnsolvableGeometryError: it has symbols, or other joints.
    """
    require(not robot.free_symbols, robot, "has symbolic parameters")
    links = standard_links(robot)
    moving = [link.joint for link in links if link.moves]
    given = "".join("R" if joint is Joint.REVOLUTE else "P" for joint in moving)
    require(given == kinds, robot, f"its joints are {given}, not {kinds}")
    T, directions, points = np.eye(4), [], []
    for link in links:
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

    Raises:
        UnsolvableGeometryError: they do not meet.
    """
    three = range(first - 1, first + 2)
    planes = [np.eye(3) - np.outer(axes.direction[i], axes.direction[i]) for i in three]
    right = np.concatenate([P @ axes.point[i] for P, i in zip(planes, three, strict=True)])
    point = np.linalg.lstsq(np.concatenate(planes), right)[0]
    gap = float(np.abs(np.concatenate(planes) @ point - right).max())
    complaint = f"axes {first}, {first + 1} and {first + 2} do not meet, they are {gap:.3g} m apart"
    require(gap < SQUARE, robot, complaint)
    return np.asarray(point, dtype=np.float64)


def batch(T: ArrayLike) -> tuple[Array, bool]:
    """Checked targets (N, 4, 4), and True for a single one."""
    given = real_array("T", T)
    if given.ndim not in (2, 3) or given.shape[-2:] != (4, 4):
        raise ValueError(f"T must have shape (4, 4) or (N, 4, 4), got {given.shape}")
    check_rigid(given)
    return given.reshape(-1, 4, 4), given.ndim == 2


def branches_of(
    robot: Robot, q: Array, exists: NDArray[np.bool_], singular: Any, single: bool
) -> Branches:
    """Motor angles of joint variables q (N, b, n), revolute joints within half a turn of phi = 0.

    exists and singular: (N, b); NaN where a branch does not exist.
    """
    revolute = np.array([robot.links[i].joint is Joint.REVOLUTE for i in robot.moving])
    turns = np.where(revolute, np.round((q - robot.offset) / (2 * np.pi)), 0.0)
    phi = robot.motor_angles(np.nan_to_num(q) - 2 * np.pi * np.nan_to_num(turns))
    phi[~exists] = np.nan
    flags = np.where(exists, singular, 0).astype(np.int8)
    return Branches(phi[0], exists[0], flags[0]) if single else Branches(phi, exists, flags)
