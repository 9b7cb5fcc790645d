"""Geometry of an elbow arm with a spherical wrist, and the test that a robot is one.

Both work on a standard Denavit-Hartenberg table; a modified one is converted first.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import atan2, cos, hypot, sin

import numpy as np

from armside.arrays import Array

from .. import rigid
from ..dh import Joint, Link, Robot
from ..links import chain_transform, link_transform, standard_links

_TINY = 1e-12  # [m] or [-]: a table's zero, or the cosine of a table's pi/2
_FALLBACK = "use armside.kinematics.inverse_numeric, which needs a start configuration"


class UnsolvableGeometryError(ValueError):
    """A robot that is no elbow arm with a spherical wrist: no closed form."""


@dataclass(frozen=True)
class WristArm:
    """Constants of the closed form.

    Inverse transforms (4, 4) of the links before the first joint and of everything after
    Rot_z(theta6), the vector g of the compiled kernel, and theta = M phi + constant.
    """

    head_inverse: Array
    tail_inverse: Array
    geometry: Array
    M: Array
    M_inverse: Array
    constant: Array

    @property
    def reach(self) -> tuple[float, float]:
        """Least and greatest distance of the wrist centre from axis 2 [m], in the arm's plane."""
        a2, L = self.geometry[4], self.geometry[5]
        return abs(a2 - L), a2 + L


@lru_cache(maxsize=64)
def wrist_arm(robot: Robot) -> WristArm:
    """The geometry of a solvable robot.

    Raises:
        UnsolvableGeometryError: says which parameter stands in the way, and the numeric fallback.
    """
    _require(not robot.free_symbols, robot, "has symbolic parameters")
    links = standard_links(robot)
    moving = [i for i, link in enumerate(links) if link.moves]
    _require(len(moving) == 6, robot, f"has {len(moving)} joints, not 6")
    first, last = moving[0], moving[-1]
    _require(last - first == 5, robot, "has constant links between its joints")
    six = links[first : last + 1]
    for number, link in enumerate(six, 1):
        _require(link.joint is Joint.REVOLUTE, robot, f"joint {number} is not revolute")
    _check_wrist(robot, six)
    _check_arm(robot, six)
    head, rest = chain_transform(links[:first]), chain_transform(links[last + 1 :])
    tail = link_transform(replace(six[5], theta=0, joint=Joint.FIXED)) @ rest
    M, constant = robot.coupling.copy(), robot.offset + [float(link.theta) for link in six]
    if float(six[1].a) < 0:  # the same arm with a2 > 0, theta2 half a turn on and theta3 back
        constant[1:3] += np.pi, -np.pi * np.sign(cos(float(six[1].alpha)))
    M_inverse = np.asarray(np.linalg.inv(M), dtype=np.float64)
    ends = rigid.inverse(head), rigid.inverse(tail)
    return WristArm(*ends, _geometry(six), M, M_inverse, constant)


def _require(condition: bool, robot: Robot, complaint: str) -> None:
    if not condition:
        raise UnsolvableGeometryError(
            f"no closed-form inverse for {robot.name}: {complaint}; {_FALLBACK}"
        )


def _check_wrist(robot: Robot, six: tuple[Link, ...]) -> None:
    """Axes 4, 5, 6 meet in one point, at right angles."""
    for name, value in (("a4", six[3].a), ("a5", six[4].a), ("d5", six[4].d)):
        complaint = f"the wrist is not spherical: {name} = {value} m"
        _require(abs(float(value)) < _TINY, robot, complaint)
    for name, link in (("alpha4", six[3]), ("alpha5", six[4])):
        complaint = f"the wrist axes are not at right angles: {name} = {link.alpha} rad"
        _require(abs(cos(float(link.alpha))) < _TINY, robot, complaint)


def _check_arm(robot: Robot, six: tuple[Link, ...]) -> None:
    """Axis 2 is parallel to axis 3 and not to axis 1; both arm lengths are there."""
    alpha1, alpha2 = float(six[0].alpha), float(six[1].alpha)
    _require(abs(sin(alpha2)) < _TINY, robot, f"axes 2 and 3 are not parallel: alpha2 = {alpha2}")
    _require(abs(sin(alpha1)) > 1e-6, robot, f"axes 1 and 2 are parallel: alpha1 = {alpha1}")
    g = _geometry(six)
    _require(g[4] > _TINY and g[5] > _TINY, robot, "upper arm or forearm has no length")


def _geometry(six: tuple[Link, ...]) -> Array:
    d1, d2, d3, d4 = (float(link.d) for link in six[:4])
    a1, a2, a3 = (float(link.a) for link in six[:3])
    alpha1, alpha2, alpha3 = (float(link.alpha) for link in six[:3])
    sigma = 1.0 if cos(alpha2) > 0 else -1.0
    forearm = (a3, -sigma * sin(alpha3) * d4)
    offset = d2 + sigma * (d3 + cos(alpha3) * d4)
    return np.array(
        [
            d1, a1, sin(alpha1), cos(alpha1), abs(a2), hypot(*forearm),
            atan2(forearm[1], forearm[0]), offset, sigma, sin(float(six[3].alpha)),
            sin(float(six[4].alpha)), sin(alpha3), cos(alpha3),
        ]
    )  # fmt: skip
