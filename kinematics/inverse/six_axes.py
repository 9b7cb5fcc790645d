"""Geometry of six revolute axes in a row that a closed form of inverse kinematics exists for.

An elbow arm has a spherical wrist; of an arm as Universal Robots builds them axes 2, 3 and 4 are
parallel. The tests work on a standard Denavit-Hartenberg table; a modified one is converted first.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import atan2, cos, hypot, pi, sin

import numpy as np

from armside.arrays import Array

from .. import rigid
from ..dh import Joint, Link, Robot
from ..rigid import chain_transform, link_transform, standard_links

TINY = 1e-12  # [m] or [-]: a table's zero, or the cosine of a table's pi/2
_FALLBACK = "use armside.kinematics.inverse_numeric, which needs a start configuration"


class UnsolvableGeometryError(ValueError):
    """A robot of a kind that no closed form is known for."""


@dataclass(frozen=True)
class ClosedArm:
    """Constants of a closed form.

    Name of its kernel, "wrist" or "parallel", inverse transforms (4, 4) of the links before the
    first joint and of everything after Rot_z(theta6), the vector g of the kernel, and
    theta = M phi + constant, where theta are the angles of that kernel.
    """

    kernel: str
    head_inverse: Array
    tail_inverse: Array
    geometry: Array
    M: Array
    M_inverse: Array
    constant: Array


def require(condition: bool, robot: Robot, complaint: str) -> None:
    """Refuse a robot that a closed form does not hold for."""
    if not condition:
        raise UnsolvableGeometryError(
            f"no closed-form inverse for {robot.name}: {complaint}; {_FALLBACK}"
        )


@lru_cache(maxsize=64)
def solvable_arm(robot: Robot) -> ClosedArm:
    """Constants of the closed form of a robot's kind.

    Raises UnsolvableGeometryError: there is none; says which parameter stands in the way.
    """
    try:
        return wrist_arm(robot)
    except UnsolvableGeometryError:
        if all(abs(sin(float(link.alpha))) < TINY for link in _six_links(robot)[1:3]):
            return _parallel_arm(robot)
        raise


def wrist_arm(robot: Robot) -> ClosedArm:
    """Constants of an elbow arm with a spherical wrist. Raises UnsolvableGeometryError."""
    six, shift = _six_links(robot), np.zeros(6)
    for name, value in (("a4", six[3].a), ("a5", six[4].a), ("d5", six[4].d)):
        complaint = f"the wrist is not spherical: {name} = {value} m"
        require(abs(float(value)) < TINY, robot, complaint)
    d1, d2, d3, d4 = (float(link.d) for link in six[:4])
    a1, a2, a3 = (float(link.a) for link in six[:3])
    alpha1, alpha2, alpha3 = (float(link.alpha) for link in six[:3])
    require(abs(sin(alpha2)) < TINY, robot, f"axes 2 and 3 are not parallel: alpha2 = {alpha2}")
    sigma = 1.0 if cos(alpha2) > 0 else -1.0
    forearm = (a3, -sigma * sin(alpha3) * d4)
    offset = d2 + sigma * (d3 + cos(alpha3) * d4)
    geometry = np.array(
        [
            d1, a1, sin(alpha1), cos(alpha1), abs(a2), hypot(*forearm),
            atan2(forearm[1], forearm[0]), offset, sigma, sin(float(six[3].alpha)),
            sin(float(six[4].alpha)), sin(alpha3), cos(alpha3),
        ]
    )  # fmt: skip
    if a2 < 0:  # the same arm with a2 > 0, theta2 half a turn on and theta3 back
        shift[1:3] = pi, -pi * np.sign(cos(alpha2))
    return _closed_arm("wrist", robot, six, geometry, shift)


def _parallel_arm(robot: Robot) -> ClosedArm:
    """Constants of a robot whose axes 2, 3 and 4 are parallel; all lengths but a5 may be there."""
    six = _six_links(robot)
    d1, d2, d3, d4, d5 = (float(link.d) for link in six[:5])
    a1, a2, a3, a4, a5 = (float(link.a) for link in six[:5])
    alpha1, t, s = float(six[0].alpha), sin(float(six[3].alpha)), sin(float(six[4].alpha))
    require(abs(a5) < TINY, robot, f"axes 5 and 6 do not meet: a5 = {a5} m")
    # sigma = cos alpha2 and tau = cos alpha2 cos alpha3: axes 3 and 4 along axis 2 or against
    sigma, following = (1.0 if cos(float(link.alpha)) > 0 else -1.0 for link in six[1:3])
    tau = sigma * following
    side, offset = t * tau, d2 + sigma * d3 + tau * d4
    geometry = np.array(
        [
            d1, a1, sin(alpha1), cos(alpha1), abs(a2), abs(a3), hypot(a4, d5),
            atan2(-side * d5, a4), offset, sigma, tau, side, s,
        ]
    )  # fmt: skip
    # half turns of theta2, theta3 and theta4 that make a2 and a3 positive
    upper, fore = (pi if a < 0 else 0.0 for a in (a2, a3))
    shift = np.array([0.0, upper, sigma * (fore - upper), -tau * fore, 0.0, 0.0])
    return _closed_arm("parallel", robot, six, geometry, shift)


def _six_links(robot: Robot) -> tuple[Link, ...]:
    """The moving links of a robot of six revolute joints, in the standard convention."""
    require(not robot.free_symbols, robot, "has symbolic parameters")
    links = standard_links(robot)
    moving = [i for i, link in enumerate(links) if link.moves]
    require(len(moving) == 6, robot, f"has {len(moving)} joints, not 6")
    require(moving[5] - moving[0] == 5, robot, "has constant links between its joints")
    six = links[moving[0] : moving[5] + 1]
    for number, link in enumerate(six, 1):
        require(link.joint is Joint.REVOLUTE, robot, f"joint {number} is not revolute")
    return six


def _closed_arm(
    kernel: str, robot: Robot, six: tuple[Link, ...], geometry: Array, shift: Array
) -> ClosedArm:
    """Constants of a robot, once its first axes and its wrist are checked.

    shift: (6,) [rad], takes D-H angles to the kernel's.
    """
    for number in (4, 5):
        alpha = six[number - 1].alpha
        complaint = f"the wrist axes are not at right angles: alpha{number} = {alpha} rad"
        require(abs(cos(float(alpha))) < TINY, robot, complaint)
    alpha1 = float(six[0].alpha)
    require(abs(sin(alpha1)) > 1e-6, robot, f"axes 1 and 2 are parallel: alpha1 = {alpha1}")
    require(min(geometry[4:6]) > TINY, robot, "upper arm or forearm has no length")
    links = standard_links(robot)
    first = next(i for i, link in enumerate(links) if link.moves)
    head, rest = chain_transform(links[:first]), chain_transform(links[first + 6 :])
    tail = link_transform(replace(six[5], theta=0, joint=Joint.FIXED)) @ rest
    constant = robot.offset + [float(link.theta) for link in six] + shift
    M = robot.coupling.copy()
    M_inverse = np.asarray(np.linalg.inv(M), dtype=np.float64)
    return ClosedArm(
        kernel, rigid.inverse(head), rigid.inverse(tail), geometry, M, M_inverse, constant
    )
