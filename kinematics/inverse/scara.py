"""Inverse kinematics of SCARAs in closed form: three revolute axes and a slide, all parallel.

The tool turns about these axes alone. In complex numbers for the plane across them, the third
revolute axis is at l_1 e^(i A) + l_2 e^(i B), and the tool turns by the sum of all angles.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ..dh import Robot
from .closed_form import Branches, Singularity, refuse_unreachable
from .screws import SQUARE, branches_of, screws
from .six_axes import require
from .targets import batch

_TOUCHING = 1e-10  # [m] outside the reach that counts as rounding
_STRETCHED = 1e-7  # sine of the elbow
_TILT = 1e-9  # [rad] of the tool against the axes that counts as rounding


def scara_branches(robot: Robot, T: ArrayLike) -> Branches:
    """Both elbow branches for each target; motor angles (..., 2, 4) [rad, m], T as (..., 4, 4).

    Raises:
        UnreachableError: a target has no solution; says its distance from the workspace.
        ValueError: a target is tilted against the axes.
        UnsolvableGeometryError: the robot is no SCARA; says why.
    """
    slides = np.flatnonzero(robot.slides).tolist()
    complaint = f"has {robot.n_joints} joints and {len(slides)} slides, a SCARA has 4 and 1"
    require(robot.n_joints == 4 and len(slides) == 1, robot, complaint)
    slide = slides[0]
    axes = screws(robot, "".join("P" if i == slide else "R" for i in range(4)))
    crossed = np.linalg.norm(np.cross(axes.direction, axes.direction[0]), axis=1)
    require(bool((crossed < SQUARE).all()), robot, "its axes are not parallel")
    turning = [i for i in range(4) if i != slide]
    between = np.cross(np.diff(axes.point[turning], axis=0), axes.direction[0])
    apart = bool((np.linalg.norm(between, axis=1) > SQUARE).all())
    require(apart, robot, "upper arm or forearm has no length")
    targets, single = batch(T)
    z = axes.direction[0]
    other = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = other - (other @ z) * z
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    sign = axes.direction @ z
    turn = targets[:, :3, :3] @ axes.tool[:3, :3].T
    turned = turn @ z
    tilt = np.arctan2(np.linalg.norm(np.cross(turned, z), axis=1), turned @ z)
    if tilt.max(initial=0.0) > _TILT:
        k = int(np.argmax(tilt))
        by = f"{np.degrees(tilt[k]):.3g} deg"
        raise ValueError(f"target {k} is tilted by {by} against the axes of {robot.name}")
    total = np.arctan2((turn @ x) @ y, (turn @ x) @ x)
    plane = x + 1j * y
    first, second, third = (axes.point[i] @ plane for i in turning)
    tool = axes.tool[:3, 3] @ plane
    third_axis = targets[:, :3, 3] @ plane - np.exp(1j * total) * (tool - third)
    A, B, outside, bent = _elbow(third_axis - first, second - first, third - second)
    refuse_unreachable(robot, outside, _TOUCHING)
    q = np.empty((len(targets), 2, 4))
    angles = A, B - A, total[:, None] - B
    for joint, angle in zip(turning, angles, strict=True):
        q[..., joint] = sign[joint] * angle
    height = (targets[:, :3, 3] - axes.tool[:3, 3]) @ z
    q[..., slide] = (sign[slide] * height)[:, None]
    flags = np.where(bent, 0, Singularity.ELBOW)[:, None] * np.ones((1, 2), dtype=int)
    return branches_of(robot, q, np.ones(q.shape[:2], dtype=bool), flags, single)


def _elbow(w: Any, l1: complex, l2: complex) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """A and B (N, 2) with l1 e^(i A) + l2 e^(i B) = w, distance [m] outside, and bent (N,)."""
    a, b, D = abs(l1), abs(l2), np.abs(w)
    outside = np.maximum(D - (a + b), abs(a - b) - D)
    area = np.maximum(D - abs(a - b), 0) * (D + abs(a - b))
    area = area * np.maximum(a + b - D, 0) * (a + b + D)
    sine = np.sqrt(area) / (2 * a * b)
    gamma = np.arctan2(sine, (D**2 - a * a - b * b) / (2 * a * b))
    bend = np.array([1.0, -1.0]) * gamma[:, None]
    A = np.angle(w)[:, None] - np.angle(a + b * np.exp(1j * bend))
    return A - np.angle(l1), A + bend - np.angle(l2), outside, sine >= _STRETCHED
