"""Geometry of an elbow arm with a spherical wrist, and the test that a robot is one.

Both work on a standard Denavit-Hartenberg table; a modified one is converted first.
"""

from functools import lru_cache
from math import atan2, cos, hypot, pi, sin

import numpy as np

from armside.arrays import Array

from ..dh import Link, Robot
from .six_axes import TINY, ClosedArm, closed_arm, require, six_links


class WristArm(ClosedArm):
    """Constants of the closed form of an elbow arm with a spherical wrist."""

    @property
    def reach(self) -> tuple[float, float]:
        """Least and greatest distance of the wrist centre from axis 2 [m], in the arm's plane."""
        a2, L = self.geometry[4], self.geometry[5]
        return abs(a2 - L), a2 + L


@lru_cache(maxsize=64)
def wrist_arm(robot: Robot) -> WristArm:
    """The geometry of an elbow arm with a spherical wrist.

    Raises:
        UnsolvableGeometryError: says which parameter stands in the way, and the numeric fallback.
    """
    six, shift = six_links(robot), np.zeros(6)
    _check_wrist(robot, six)
    _check_arm(robot, six)
    if float(six[1].a) < 0:  # the same arm with a2 > 0, theta2 half a turn on and theta3 back
        shift[1:3] = pi, -pi * np.sign(cos(float(six[1].alpha)))
    return closed_arm(WristArm, robot, _geometry(six), shift)


def _check_wrist(robot: Robot, six: tuple[Link, ...]) -> None:
    """Axes 4, 5, 6 meet in one point, at right angles."""
    for name, value in (("a4", six[3].a), ("a5", six[4].a), ("d5", six[4].d)):
        complaint = f"the wrist is not spherical: {name} = {value} m"
        require(abs(float(value)) < TINY, robot, complaint)
    for name, link in (("alpha4", six[3]), ("alpha5", six[4])):
        complaint = f"the wrist axes are not at right angles: {name} = {link.alpha} rad"
        require(abs(cos(float(link.alpha))) < TINY, robot, complaint)


def _check_arm(robot: Robot, six: tuple[Link, ...]) -> None:
    """Axis 2 is parallel to axis 3 and not to axis 1; both arm lengths are there."""
    alpha1, alpha2 = float(six[0].alpha), float(six[1].alpha)
    require(abs(sin(alpha2)) < TINY, robot, f"axes 2 and 3 are not parallel: alpha2 = {alpha2}")
    require(abs(sin(alpha1)) > 1e-6, robot, f"axes 1 and 2 are parallel: alpha1 = {alpha1}")
    g = _geometry(six)
    require(g[4] > TINY and g[5] > TINY, robot, "upper arm or forearm has no length")


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
