"""Pose and Jacobian of a serial arm with an error of every geometric parameter.

The arm is a chain of sections: two of the base frame, one of each link, two of the tool frame. A
section is a short robot whose joints are its parameters: a turn and a slide about each axis. Its
pose and Jacobian are derived by the symbolic toolbox and compiled, as one function: nothing is
derived or compiled for a particular arm.
"""

from functools import cache
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from armside.arrays import Array

from ..dh import Joint, Link, Robot
from ..native_function import native_function, native_module

if TYPE_CHECKING:
    from ..equations.program import StraightLineProgram

_X = (Link(theta=pi / 2, alpha=pi / 2, joint=Joint.FIXED),)
_X_BACK = (Link(alpha=-pi / 2, joint=Joint.FIXED), Link(theta=-pi / 2, joint=Joint.FIXED))
_Y = (Link(alpha=-pi / 2, joint=Joint.FIXED),)
_Y_BACK = (Link(alpha=pi / 2, joint=Joint.FIXED),)
"""Constant links that take the z-axis to x or y, and back."""
_SLIDE, _TURN = Link(joint=Joint.PRISMATIC), Link()
_SECTION = (_TURN, _SLIDE, *_X, _SLIDE, _TURN, *_X_BACK, *_Y, _SLIDE, _TURN, *_Y_BACK)
SIZE = 6
"""Parameters of a section: rz, z, x, rx, y, ry [rad, m], each in the axes of those before it."""
BASE = ((2, 3, 4, 5), (1, 0))
"""Parameters of the sections of the base frame: x, rx, y, ry; then z, rz."""
LINK = (0, 1, 2, 3, 5)
"""theta, d, a, alpha, and Hayati's beta about y."""
TOOL = ((3, 5), (0,))
"""rx, ry; then rz."""


class Section(NamedTuple):
    """Poses (N, 4, 4) and Jacobians (N, 6, m) of a section, in axes of its beginning."""

    pose: Array
    jacobian: Array


@cache
def _function() -> Any:
    robot = Robot(_SECTION, name="section with errors")

    def program() -> "StraightLineProgram":
        from ..equations.forward_kinematics import pose_and_jacobian

        return pose_and_jacobian(robot)

    module = native_module("pose_and_jacobian", robot.key, program)
    return native_function(module, (SIZE,), (16 + 6 * SIZE,))


def sections(variables: Array) -> Section:
    """Sections of parameters (N, 6)."""
    both = _function()(np.ascontiguousarray(variables))
    return Section(both[:, :16].reshape(-1, 4, 4), both[:, 16:].reshape(-1, 6, SIZE))


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
