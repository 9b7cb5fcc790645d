"""Inverse kinematics of seven revolute axes in closed form, by a stated elbow angle.

Axes 1, 2, 3 meet in the shoulder, axes 5, 6, 7 in the wrist, each at right angles to the next, and
axis 4 is the elbow (S-R-S). The elbow angle is that of the plane of shoulder, elbow and wrist about
the line from shoulder to wrist; at 0 the elbow is on the side that axis 1 points to. After
M. Shimizu et al., IEEE Trans. Robotics 24 (2008), with another plane of reference.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, finite_array, real_array

from ..dh import Robot
from ..rotation import from_axis_angle
from .closed_form import Branches, Singularity, refuse_unreachable
from .screws import SQUARE, Screws, branches_of, meeting_point, require_square, screws, three_axes
from .six_axes import require
from .targets import batch

_TOUCHING = 1e-10  # [m] outside the reach that counts as rounding
_NEAR = 1e-7  # [m] of the elbow from the line of shoulder and wrist, [-] of that line from axis 1
_COINCIDENT = 1e-100  # [m] from shoulder to wrist of a folded arm, for which it may be 0


@dataclass(frozen=True)
class _Arm:
    axes: Screws
    shoulder: Array
    elbow: Array
    wrist: Array


def seven_axis_branches(robot: Robot, T: ArrayLike, elbow: ArrayLike) -> Branches:
    """All eight branches for each target at an elbow angle, motor angles (..., 8, 7) [rad].

    They are numbered 4 shoulder + 2 elbow + wrist.

    Args:
        T: (4, 4) or (N, 4, 4), T_base_tool.
        elbow: elbow angle [rad], one or (N,).

    Raises:
        UnreachableError: a target has no solution; says its distance from the workspace.
        UnsolvableGeometryError: the robot is of another kind; says why.
    """
    arm = _arm(robot)
    targets, single = batch(T)
    psi = finite_array("elbow", elbow)
    if psi.shape not in ((), (len(targets),)):
        raise ValueError(f"elbow must be one angle or ({len(targets)},), got shape {psi.shape}")
    psi = np.broadcast_to(psi, len(targets))
    turn = targets[:, :3, :3] @ arm.axes.tool[:3, :3].T
    W = targets[:, :3, 3] - turn @ (arm.axes.tool[:3, 3] - arm.wrist)
    d, D = _line(arm, W)
    L1, L2 = (float(np.linalg.norm(end - arm.elbow)) for end in (arm.shoulder, arm.wrist))
    outside = np.maximum(D - (L1 + L2), abs(L1 - L2) - D)
    refuse_unreachable(robot, outside, _TOUCHING)
    u, q = arm.axes.direction, np.empty((len(targets), 8, 7))
    flags, side, beside = np.empty((len(targets), 8), dtype=int), *_side(u[0], d, psi)
    for bent, sign in enumerate((1.0, -1.0)):
        q4, R_s, straight = _bend(arm, (L1, L2), d, D, side, sign)
        rest = from_axis_angle(u[3], -q4) @ np.swapaxes(R_s, 1, 2) @ turn
        shoulder, above = three_axes(R_s, u[:3])
        wrist, aligned = three_axes(rest, u[4:])
        flag = np.where(beside | above, Singularity.SHOULDER, 0)
        flag = flag | np.where(straight, Singularity.ELBOW, 0)
        flag = flag | np.where(aligned, Singularity.WRIST, 0)
        for one in range(2):
            for two in range(2):
                b = 4 * one + 2 * bent + two
                q[:, b, :3], q[:, b, 3], q[:, b, 4:] = shoulder[:, one], q4, wrist[:, two]
                flags[:, b] = flag
    return branches_of(robot, q, np.ones(flags.shape, dtype=bool), flags, single)


def elbow_angle(robot: Robot, phi: ArrayLike) -> float:
    """Elbow angle [rad] of a configuration phi (7,), as `seven_axis_branches` takes it.

    Raises:
        UnsolvableGeometryError: the robot is of another kind; says why.
    """
    arm, q = _arm(robot), robot.joint_variables(real_array("phi", phi, 7))
    u = arm.axes.direction
    R = from_axis_angle(u[0], q[0]) @ from_axis_angle(u[1], q[1]) @ from_axis_angle(u[2], q[2])
    forearm = from_axis_angle(u[3], q[3]) @ (arm.wrist - arm.elbow)
    upper = R @ (arm.elbow - arm.shoulder)
    d, _ = _line(arm, (arm.shoulder + upper + R @ forearm)[None])
    side, _ = _side(u[0], d, np.zeros(1))
    return float(np.arctan2(upper @ np.cross(d[0], side[0]), upper @ side[0]))


def _arm(robot: Robot) -> _Arm:
    axes = screws(robot, "RRRRRRR")
    for one in (1, 2, 5, 6):
        require_square(robot, axes, one, one + 1)
    shoulder, wrist = (meeting_point(robot, axes, first) for first in (1, 5))
    u, p = axes.direction[3], axes.point[3]
    elbow = p + u * (u @ (shoulder - p))
    gap = abs(float(u @ (wrist - elbow)))
    require(gap < SQUARE, robot, f"shoulder and wrist are {gap:.3g} m apart along axis 4")
    lengths = [float(np.linalg.norm(end - elbow)) for end in (shoulder, wrist)]
    require(min(lengths) > SQUARE, robot, "upper arm or forearm has no length")
    return _Arm(axes, shoulder, elbow, wrist)


def _line(arm: _Arm, W: Array) -> tuple[Array, Array]:
    """Unit vectors (N, 3) from the shoulder to wrist centres W (N, 3), and their distances [m].

    A wrist centre in the shoulder itself has no direction, and that of axis 1 is returned.
    """
    D = np.linalg.norm(W - arm.shoulder, axis=1)
    d = (W - arm.shoulder) / np.maximum(D, SQUARE)[:, None]
    return np.where(D[:, None] < SQUARE, arm.axes.direction[0], d), D


def _side(axis: Array, d: Array, psi: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Unit vectors (N, 3) across d that the elbow is on; True where d is along axis 1, and the
    angle is counted from another direction."""
    across = axis - (d @ axis)[:, None] * d
    along = np.linalg.norm(across, axis=1) < _NEAR
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    across = np.where(along[:, None], other - (d @ other)[:, None] * d, across)
    e = across / np.linalg.norm(across, axis=1, keepdims=True)
    return np.cos(psi)[:, None] * e + np.sin(psi)[:, None] * np.cross(d, e), along


def _bend(
    arm: _Arm, lengths: tuple[float, float], d: Array, D: Array, side: Array, sign: float
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """q_4 (N,), rotation (N, 3, 3) of the upper arm, and True where the arm is straight."""
    L1, L2 = lengths
    s, w, u = arm.shoulder - arm.elbow, arm.wrist - arm.elbow, arm.axes.direction[3]
    D = np.clip(D, max(abs(L1 - L2), _COINCIDENT), L1 + L2)
    area = np.maximum(D - abs(L1 - L2), 0) * (D + abs(L1 - L2))
    area = np.sqrt(area * np.maximum(L1 + L2 - D, 0) * (L1 + L2 + D)) / 2  # 2 L1 L2 sin, halved
    inner = np.arctan2(2 * area, L1 * L1 + L2 * L2 - D * D)
    q4 = sign * inner - np.arctan2(u @ np.cross(s, w), s @ w)
    height = area / D
    along = (D * D + (L1 - L2) * (L1 + L2)) / (2 * D)
    upper = (along[:, None] * d + height[:, None] * side) / L1
    normal = sign * np.cross(d, side)
    now = np.stack([upper, normal, np.cross(upper, normal)], axis=-1)
    first = np.stack([-s / L1, u, np.cross(-s / L1, u)], axis=-1)
    R = np.asarray(now @ first.T, dtype=np.float64)
    return q4, R, (height < _NEAR) | (area < _NEAR * L1 * L2)
