"""Rigid motions as homogeneous transforms, numeric, also of links. Thesis (2.2), (3.15)-(3.29).

Frames read as a sum: p_a = T_a_b @ p_b. Every function takes leading batch axes.
"""

from collections.abc import Iterable
from dataclasses import replace
from math import cos, sin

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, real_array

from .dh import Convention, Joint, Link, Robot

ORTHOGONAL = 1e-6
"""Greatest element of R^T R - 1 of a matrix that counts as a rotation."""


def transform(R: ArrayLike, d: ArrayLike) -> Array:
    """T = [R d; 0 1], shape (..., 4, 4). Thesis (3.17)."""
    R, d = real_array("R", R), real_array("d", d)
    if R.shape[-2:] != (3, 3) or d.shape[-1:] != (3,):
        raise ValueError(f"R must be (..., 3, 3) and d (..., 3), got {R.shape} and {d.shape}")
    T = np.zeros((*np.broadcast_shapes(R.shape[:-2], d.shape[:-1]), 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, d, 1.0
    return T


def inverse(T_a_b: ArrayLike) -> Array:
    """T_b_a = [R^T, -R^T d; 0 1]. Thesis (3.20)."""
    T = real_array("T_a_b", T_a_b, 4, 4)
    R_b_a = np.swapaxes(T[..., :3, :3], -1, -2)
    if not np.allclose(R_b_a @ T[..., :3, :3], np.eye(3), rtol=0, atol=ORTHOGONAL):
        raise ValueError("T_a_b must be a rigid motion: its rotation is not orthogonal")
    return transform(R_b_a, -(R_b_a @ T[..., :3, 3:])[..., 0])


def transform_points(T_a_b: ArrayLike, p_b: ArrayLike) -> Array:
    """p_a = R p_b + d for points p_b of shape (..., 3). Thesis (3.15)."""
    T, p = real_array("T_a_b", T_a_b, 4, 4), real_array("p_b", p_b, 3)
    return (T[..., :3, :3] @ p[..., None])[..., 0] + T[..., :3, 3]


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
