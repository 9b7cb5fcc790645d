"""Masses of the moving links of a URDF chain, as bodies of a robot file."""

import numpy as np

from armside.kinematics.equations.inertial_model import Body
from armside.kinematics.urdf import UrdfArm

from .description import LinkBody
from .inertia import SMALLEST, matrix


def bodies_of(arm: UrdfArm) -> tuple[LinkBody, ...]:
    """Bodies of the moving links, in the axes of their D-H frames; none where it has no masses."""
    if arm.bodies is None:
        return ()
    moving = [b for b, link in zip(arm.bodies, arm.robot.links, strict=True) if link.moves]
    return tuple(link_body(body) for body in moving)


def link_body(body: Body) -> LinkBody:
    """A body, or one to be estimated where it has no mass; so is the inertia of a point."""
    if not float(body.mass) > 0.0:
        return LinkBody()
    x, y, z = map(float, body.com)
    xx, yy, zz, xy, xz, yz = map(float, body.inertia)
    inertia = xx, yy, zz, xy, xz, yz
    point = np.linalg.eigvalsh(matrix(inertia))[0] < SMALLEST
    return LinkBody(mass=float(body.mass), centre=(x, y, z), inertia=None if point else inertia)
