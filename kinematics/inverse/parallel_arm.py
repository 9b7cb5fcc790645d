"""Geometry of an arm whose axes 2, 3 and 4 are parallel, as Universal Robots builds them.

The test works on a standard Denavit-Hartenberg table; a modified one is converted first.
"""

from math import atan2, cos, hypot, pi, sin

import numpy as np

from armside.arrays import Array

from ..dh import Link, Robot
from .six_axes import TINY, ClosedArm, closed_arm, require, six_links


class ParallelArm(ClosedArm):
    """Constants of the closed form of an arm with three parallel axes."""


def has_parallel_axes(robot: Robot) -> bool:
    """True if axes 2, 3 and 4 of six revolute axes are parallel.

    Raises:
        UnsolvableGeometryError: the robot has no six revolute joints in a row.
    """
    return all(abs(sin(float(link.alpha))) < TINY for link in six_links(robot)[1:3])


def parallel_arm(robot: Robot) -> ParallelArm:
    """The geometry of a robot with `has_parallel_axes`; all lengths but a5 may be there.

    Raises:
        UnsolvableGeometryError: says which parameter stands in the way, and the numeric fallback.
    """
    six = six_links(robot)
    for number in (4, 5):
        alpha = six[number - 1].alpha
        complaint = f"the wrist axes are not at right angles: alpha{number} = {alpha} rad"
        require(abs(cos(float(alpha))) < TINY, robot, complaint)
    a2, a3, a5 = (float(six[i].a) for i in (1, 2, 4))
    require(abs(a5) < TINY, robot, f"axes 5 and 6 do not meet: a5 = {a5} m")
    alpha1 = float(six[0].alpha)
    require(abs(sin(alpha1)) > 1e-6, robot, f"axes 1 and 2 are parallel: alpha1 = {alpha1}")
    require(abs(a2) > TINY and abs(a3) > TINY, robot, "upper arm or forearm has no length")
    return closed_arm(ParallelArm, robot, _geometry(six), _shift(six))


def _turns(six: tuple[Link, ...]) -> tuple[float, float]:
    """sigma = cos alpha2 and tau = cos alpha2 cos alpha3: axes 3 and 4 along axis 2 or against."""
    sigma, following = (1.0 if cos(float(link.alpha)) > 0 else -1.0 for link in six[1:3])
    return sigma, sigma * following


def _shift(six: tuple[Link, ...]) -> Array:
    """Half turns of theta2, theta3 and theta4 that make a2 and a3 positive."""
    sigma, tau = _turns(six)
    upper, fore = (pi if float(link.a) < 0 else 0.0 for link in six[1:3])
    return np.array([0.0, upper, sigma * (fore - upper), -tau * fore, 0.0, 0.0])


def _geometry(six: tuple[Link, ...]) -> Array:
    d1, d2, d3, d4, d5 = (float(link.d) for link in six[:5])
    a1, a2, a3, a4 = (float(link.a) for link in six[:4])
    alpha1, t, s = float(six[0].alpha), sin(float(six[3].alpha)), sin(float(six[4].alpha))
    sigma, tau = _turns(six)
    side, offset = t * tau, d2 + sigma * d3 + tau * d4
    return np.array(
        [
            d1, a1, sin(alpha1), cos(alpha1), abs(a2), abs(a3), hypot(a4, d5),
            atan2(-side * d5, a4), offset, sigma, tau, side, s,
        ]
    )  # fmt: skip
