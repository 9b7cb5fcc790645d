"""Frames of a chain of bodies, one for each motor, of a Denavit-Hartenberg table.

A body's z-axis is the axis of its joint. At zero motor angles it is placed by the constant links
and the offset; a motor that turns its joint backwards has the axis -z.
"""

from dataclasses import dataclass, replace

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import Convention, Joint


@dataclass(frozen=True, eq=False)
class Frame:
    """One moving body. Transforms are (4, 4)."""

    joint: Joint
    sign: float
    """Of the joint variable over the motor angle."""
    place: Array
    """In the body before it, motors at zero."""
    link: Array
    """D-H frame of its row, in the body."""
    end: Array
    """Place where the next body begins, or the tool frame, in the body."""

    @property
    def along(self) -> Array:
        """(3,) [m], from the joint's origin to the next."""
        return self.end[:3, 3]


def frames(robot: kinematics.Robot) -> list[Frame]:
    """Bodies of a robot from the base on. Raises ValueError for a coupling between motors."""
    signs = np.diag(robot.coupling)
    if not np.array_equal(np.abs(robot.coupling), np.eye(len(signs))):
        raise ValueError(
            "coupling must be diagonal with 1 or -1 for hardware that is built from the file; "
            "a robot whose motors move several joints needs a model (MJCF) of its own"
        )
    moving = iter(zip(signs, robot.offset, strict=True))
    found, T, modified = list[Frame](), np.eye(4), robot.convention is Convention.MODIFIED
    for link in robot.links:
        # Rot_x(alpha) Trans_x(a) stands before the motion along z in the modified convention.
        c, s = np.cos(float(link.alpha)), np.sin(float(link.alpha))
        twist = np.array([[1, 0, 0, float(link.a)], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])
        before, after = (twist, np.eye(4)) if modified else (np.eye(4), twist)
        if not link.moves:
            T = T @ before @ _shift(float(link.theta), float(link.d)) @ after
            continue
        if found:
            found[-1] = replace(found[-1], end=T @ before)
        sign, offset = next(moving)
        revolute = link.joint is Joint.REVOLUTE
        turned = _shift(float(link.theta) + (offset if revolute else 0.0), 0.0)
        lifted = _shift(0.0, float(link.d) + (0.0 if revolute else offset))
        place = T @ before @ turned if revolute else T @ before @ turned @ lifted
        T = lifted @ after if revolute else after
        found.append(Frame(link.joint, float(sign), place, T, T))
    found[-1] = replace(found[-1], end=T)
    return found


def points(chain: list[Frame]) -> Array:
    """(n + 1, 3) [m], origins of the joints and of the tool at zero, base axes."""
    T, found = np.eye(4), []
    for frame in chain:
        T = T @ frame.place
        found.append(T[:3, 3])
    return np.array([*found, (T @ chain[-1].end)[:3, 3]])


def _shift(theta: float, d: float) -> Array:
    """Rot_z(theta) Trans_z(d)."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, d], [0, 0, 0, 1.0]])
