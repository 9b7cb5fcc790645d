"""Pose and Jacobian of a serial arm with an error of every geometric parameter.

The arm is a chain of sections: base frame, links, tool frame. A section is a short robot
whose joints are its parameters, and its pose and Jacobian are derived by the symbolic toolbox and
compiled. All links are one section, at their own nominal values, so that nothing is derived or
compiled for a particular arm.
"""

from functools import cache
from math import pi
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..compiled import CompiledRobot, compile
from ..dh import Joint, Link, Robot

_X = (Link(theta=pi / 2, alpha=pi / 2, joint=Joint.FIXED),)
_X_BACK = (Link(alpha=-pi / 2, joint=Joint.FIXED), Link(theta=-pi / 2, joint=Joint.FIXED))
_Y = (Link(alpha=-pi / 2, joint=Joint.FIXED),)
_Y_BACK = (Link(alpha=pi / 2, joint=Joint.FIXED),)
"""Constant links that take the z-axis to x or y, and back."""
_SLIDE, _TURN = Link(joint=Joint.PRISMATIC), Link()
_FRAME = (*_X, _SLIDE, _TURN, *_X_BACK, *_Y, _SLIDE, _TURN, *_Y_BACK, _SLIDE, _TURN)
_LINK = (_TURN, _SLIDE, *_X, _SLIDE, _TURN, *_X_BACK, *_Y, _TURN, *_Y_BACK)
FRAME_ROTATIONS = (1, 3, 5)
"""Places of the rotations among a frame's parameters."""
N_FRAME, N_LINK = 6, 5


class Section(NamedTuple):
    """Poses (N, 4, 4) and Jacobians (N, 6, m) of a section, in axes of its beginning."""

    pose: Array
    jacobian: Array


@cache
def _compiled(links: tuple[Link, ...], name: str) -> CompiledRobot:
    return compile(Robot(links, name=name))


def frames(variables: Array) -> Section:
    """Frames moved by x, rx, y, ry, z, rz (N, 6) [m, rad], each in the axes of those before it."""
    return _section(_compiled(_FRAME, "frame with errors"), variables)


def links(variables: Array) -> Section:
    """Links of theta, d, a, alpha and Hayati's beta about y (N, 5) [rad, m]."""
    return _section(_compiled(_LINK, "link with errors"), variables)


def _section(robot: CompiledRobot, variables: Array) -> Section:
    flat = np.ascontiguousarray(variables)
    return Section(robot.pose(flat), robot.jacobian(flat))


def joined(sections: list[Section]) -> Section:
    """Sections one behind the other: pose of the last end and (v, omega) there, first axes."""
    T = np.broadcast_to(np.eye(4), sections[0].pose.shape)
    ends, columns = [], []
    for pose, J in sections:
        R = T[:, :3, :3]
        columns.append(np.concatenate([R @ J[:, :3], R @ J[:, 3:]], axis=1))
        T = T @ pose
        ends.append(T[:, :3, 3])
    for end, J in zip(ends, columns, strict=True):
        J[:, :3] += np.cross(J[:, 3:], (T[:, :3, 3] - end)[:, :, None], axis=1)
    return Section(T, np.concatenate(columns, axis=2))
