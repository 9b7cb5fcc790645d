"""Link transforms of a robot of numbers, in the standard Denavit-Hartenberg convention."""

from collections.abc import Iterable
from dataclasses import replace
from math import cos, sin

import numpy as np

from armside.arrays import Array

from .dh import Convention, Joint, Link, Robot


def link_transform(link: Link, variable: float = 0.0) -> Array:
    """A_i of a standard link at a joint variable [rad or m], shape (4, 4). Thesis (3.29)."""
    theta = float(link.theta) + (variable if link.joint is Joint.REVOLUTE else 0.0)
    d = float(link.d) + (variable if link.joint is Joint.PRISMATIC else 0.0)
    a, alpha = float(link.a), float(link.alpha)
    c, s, ca, sa = cos(theta), sin(theta), cos(alpha), sin(alpha)
    rows = [c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0.0, sa, ca, d]
    return np.array([*rows, [0.0, 0.0, 0.0, 1.0]])


def chain_transform(links: Iterable[Link]) -> Array:
    """Product of the link transforms at joint variables 0, shape (4, 4)."""
    T = np.eye(4)
    for link in links:
        T = T @ link_transform(link)
    return T


def link_frames(robot: Robot, phi: Array) -> list[Array]:
    """Frame (4, 4) of each link in base axes at motor angles phi (n,), in either convention."""
    T, frames, variables = np.eye(4), [], iter(robot.joint_variables(phi))
    for link in robot.links:
        variable = float(next(variables)) if link.moves else 0.0
        rod = link_transform(Link(a=link.a, alpha=link.alpha))
        screw = link_transform(replace(link, a=0, alpha=0), variable)
        standard = robot.convention is Convention.STANDARD
        T = T @ screw @ rod if standard else T @ rod @ screw
        frames.append(T)
    return frames


def standard_links(robot: Robot) -> tuple[Link, ...]:
    """The same chain as standard links; a modified table gains one constant link in front."""
    if robot.convention is Convention.STANDARD:
        return robot.links
    base = Link(a=robot.links[0].a, alpha=robot.links[0].alpha, joint=Joint.FIXED)
    following = (*robot.links[1:], Link())
    pairs = zip(robot.links, following, strict=True)
    return (base, *(replace(link, a=after.a, alpha=after.alpha) for link, after in pairs))
