"""Six revolute axes in a row: the part that every closed form of inverse kinematics shares."""

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from armside.arrays import Array

from .. import rigid
from ..dh import Joint, Link, Robot
from ..links import chain_transform, link_transform, standard_links

TINY = 1e-12  # [m] or [-]: a table's zero, or the cosine of a table's pi/2
_FALLBACK = "use armside.kinematics.inverse_numeric, which needs a start configuration"


class UnsolvableGeometryError(ValueError):
    """A robot of a kind that no closed form is known for."""


@dataclass(frozen=True)
class ClosedArm:
    """Constants of a closed form.

    Inverse transforms (4, 4) of the links before the first joint and of everything after
    Rot_z(theta6), the vector g of the compiled kernel, and theta = M phi + constant, where theta
    are the angles of that kernel.
    """

    head_inverse: Array
    tail_inverse: Array
    geometry: Array
    M: Array
    M_inverse: Array
    constant: Array


Arm = TypeVar("Arm", bound=ClosedArm)


def require(condition: bool, robot: Robot, complaint: str) -> None:
    """Refuse a robot that a closed form does not hold for."""
    if not condition:
        raise UnsolvableGeometryError(
            f"no closed-form inverse for {robot.name}: {complaint}; {_FALLBACK}"
        )


def six_links(robot: Robot) -> tuple[Link, ...]:
    """The moving links of a robot of six revolute joints, in the standard convention.

    Raises:
        UnsolvableGeometryError: says what the robot has instead.
    """
    require(not robot.free_symbols, robot, "has symbolic parameters")
    links = standard_links(robot)
    moving = [i for i, link in enumerate(links) if link.moves]
    require(len(moving) == 6, robot, f"has {len(moving)} joints, not 6")
    require(moving[5] - moving[0] == 5, robot, "has constant links between its joints")
    six = links[moving[0] : moving[5] + 1]
    for number, link in enumerate(six, 1):
        require(link.joint is Joint.REVOLUTE, robot, f"joint {number} is not revolute")
    return six


def closed_arm(kind: type[Arm], robot: Robot, geometry: Array, shift: Array) -> Arm:
    """Constants of a robot of `six_links`; shift (6,) [rad] takes D-H angles to the kernel's."""
    links = standard_links(robot)
    first = next(i for i, link in enumerate(links) if link.moves)
    six = links[first : first + 6]
    head, rest = chain_transform(links[:first]), chain_transform(links[first + 6 :])
    tail = link_transform(replace(six[5], theta=0, joint=Joint.FIXED)) @ rest
    constant = robot.offset + [float(link.theta) for link in six] + shift
    M = robot.coupling.copy()
    M_inverse = np.asarray(np.linalg.inv(M), dtype=np.float64)
    return kind(rigid.inverse(head), rigid.inverse(tail), geometry, M, M_inverse, constant)
