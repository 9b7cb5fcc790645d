"""Bodies on the moving links of a chain, summed over everything that is fixed to them."""

import numpy as np

from armside.arrays import Array

from .. import rigid
from ..equations.inertial_model import Body
from .elements import Inertial


def summed(parts: list[tuple[Array, Inertial]], frame: Array) -> Body:
    """One body in a frame (4, 4) from parts, each with its link's transform (4, 4)."""
    mass, moment, tensor = 0.0, np.zeros(3), np.zeros((3, 3))
    for T, inertial in parts:
        G = rigid.inverse(frame) @ T @ inertial.origin
        R, com, m = G[:3, :3], G[:3, 3], float(inertial.body.mass)
        mass, moment = mass + m, moment + m * com
        tensor += R @ _tensor(inertial.body) @ R.T + m * _offset(com)
    if not parts:
        return Body(mass=0)
    com = moment / mass
    tensor -= mass * _offset(com)
    i = [float(tensor[j]) for j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return Body(mass=mass, com=(*map(float, com),), inertia=(*i,))  # pyright: ignore


def _tensor(body: Body) -> Array:
    xx, yy, zz, xy, xz, yz = map(float, body.inertia)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _offset(r: Array) -> Array:
    """Inertia of a unit mass at r (3,) about the origin."""
    return (r @ r) * np.eye(3) - np.outer(r, r)
