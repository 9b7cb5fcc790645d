"""Inverse kinematics of the Stanford arm in closed form: two turns, a slide, a spherical wrist.

Axes 1 and 2 are at right angles, and so are axis 2 and the slide. Thesis (2.7)-(2.10) by another
arm: theta1 from the offset of the wrist centre along axis 2, the slide from its distance from axis
2, theta2 from its direction, and the wrist from the rotation that is left.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..dh import Robot
from ..rotation import from_axis_angle
from .closed_form import Branches, Singularity, refuse_unreachable
from .screws import Screws, branches_of, meeting_point, require_square, screws, three_axes
from .targets import batch

_TOUCHING = 1e-10  # [m] outside the reach that counts as rounding
_NEAR = 1e-7  # [m] from a singularity of the arm


def stanford_branches(robot: Robot, T: ArrayLike) -> Branches:
    """All eight branches for each target, motor angles (..., 8, 6) [rad, m], T as (..., 4, 4).

    They are numbered 4 shoulder + 2 slide + wrist: the slide out or drawn in through axis 2, which
    the limits of most arms exclude.

    Raises:
        UnreachableError: a target has no solution; says its distance from the workspace.
        UnsolvableGeometryError: the robot is of another kind; says why.
    """
    axes = screws(robot, "RRPRRR")
    for one, other in ((1, 2), (2, 3), (4, 5), (5, 6)):
        require_square(robot, axes, one, other)
    centre = meeting_point(robot, axes, 4)
    targets, single = batch(T)
    turn = targets[:, :3, :3] @ axes.tool[:3, :3].T
    C = targets[:, :3, 3] - turn @ (axes.tool[:3, 3] - centre)
    arm, short, near = _arm(axes, centre, C)
    refuse_unreachable(robot, short.min(axis=1), _TOUCHING)
    u, q = axes.direction, np.empty((len(targets), 8, 6))
    flags = np.empty((len(targets), 8), dtype=int)
    for b in range(4):
        q1, q2, _ = arm[:, b].T
        rest = from_axis_angle(u[1], -q2) @ from_axis_angle(u[0], -q1) @ turn
        wrist, aligned = three_axes(rest, u[3:])
        q[:, 2 * b : 2 * b + 2, :3] = arm[:, b, None]
        q[:, 2 * b : 2 * b + 2, 3:] = wrist
        flags[:, 2 * b : 2 * b + 2] = (near | np.where(aligned, Singularity.WRIST, 0))[:, None]
    exists = np.repeat(short <= _TOUCHING, 2, axis=1)
    return branches_of(robot, q, exists, flags, single)


def _arm(axes: Screws, centre: Array, C: Array) -> tuple[Array, Array, Any]:
    """q_1, q_2, q_3 (N, 4, 3) for wrist centres C (N, 3), distances [m] outside (N, 4), flags (N,).

    In the plane across axis 2 a vector is z + i x, with z along axis 1 and x across both axes.
    """
    y, z = axes.direction[1], axes.direction[0]
    x = np.cross(y, z)
    plane = z + 1j * x
    start, e = axes.point[1] - axes.point[0], centre - axes.point[1]
    u, v = axes.direction[2] @ plane, C - axes.point[0]
    h, rho = (start + e) @ y, np.hypot(v @ x, v @ y)
    beyond = np.abs(h) - rho
    forward = np.sqrt(np.maximum(-beyond, 0) * (rho + np.abs(h)))
    offset = (e @ plane) * np.conj(u)  # along the slide + i across it
    q, outside = np.empty((len(C), 4, 3)), np.empty((len(C), 4))
    flags = np.where(forward < _NEAR, Singularity.SHOULDER, 0)
    for shoulder, X in enumerate((forward, -forward)):
        first = np.arctan2(v @ y, v @ x) - np.arctan2(h, X)
        zeta = v @ z - start @ z + 1j * (X - start @ x)
        short = np.abs(offset.imag) - np.abs(zeta)
        outside[:, 2 * shoulder : 2 * shoulder + 2] = np.maximum(beyond, short)[:, None]
        length = np.sqrt(np.maximum(-short, 0) * (np.abs(zeta) + np.abs(offset.imag)))
        flags = flags | np.where(length < _NEAR, Singularity.ELBOW, 0)
        for drawn, slide in enumerate((length - offset.real, -length - offset.real)):
            second = np.angle(zeta * np.conj(e @ plane + slide * u))
            q[:, 2 * shoulder + drawn] = np.stack([first, second, slide], axis=-1)
    return q, outside, flags
