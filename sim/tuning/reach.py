"""Places near a named pose that a robot can reach."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from armside import kinematics
from armside.arrays import Array

from ..cell import Cell, ToolPose

FRACTIONS = (1.0, 0.5, 0.25, 0.125, 0.0)
"""Of the offset, in the order in which they are tried."""
IMMOVABLE = 1e-6
"""Singular values of the Jacobian below this part of the largest are directions without motion."""


def candidates(cell: Cell, near: ToolPose, drawn: ToolPose) -> Iterator[ToolPose]:
    """The drawn pose, moved ever closer to the named one, which comes last.

    Where the tool's orientation is free, offsets keep to the directions in which the tool moves: an
    arm in a plane stays in it.
    """
    offset = np.array(drawn.position) - np.array(near.position)
    if cell.free_rotation:
        offset = movable(cell, near) @ offset
    for fraction in FRACTIONS:
        x, y, z = (np.array(near.position) + fraction * offset).tolist()
        yield replace(near, position=(x, y, z))


def movable(cell: Cell, pose: ToolPose) -> Array:
    """Projection (3, 3) on the directions in which the tool moves at a pose."""
    start = np.zeros(cell.robot.n_joints) if cell.home is None else np.array(cell.home)
    target = np.array([pose.position])
    phi = kinematics.inverse_numeric_path(cell.robot, target, start, limits=cell.limits)[0]
    U, size, _ = np.linalg.svd(kinematics.compile(cell.robot).jacobian(phi)[:3])
    moved = U[:, : len(size)][:, size > IMMOVABLE * size[0]]
    return moved @ moved.T
