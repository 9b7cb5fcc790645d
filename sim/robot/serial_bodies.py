"""Masses of a robot's MJCF on the links of its Denavit-Hartenberg table."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics import Body, Robot
from armside.kinematics.links import link_frames
from armside.kinematics.urdf.bodies import summed
from armside.kinematics.urdf.chain import chain, children
from armside.kinematics.urdf.elements import Document, Inertial, Kind, UrdfJoint

from .mjcf import model_name
from .mjcf_document import mjcf_document
from .model import RobotModel

Part = tuple[Array, Inertial]
"""Transform (4, 4) of a link in base axes with every joint at zero, and what it weighs."""


@dataclass(frozen=True)
class SerialBodies:
    """Bodies for the links of a robot, and the names of those that no serial arm has."""

    bodies: tuple[Body, ...]
    """One for each link, as in an `InertialModel`; rotors are not among them."""
    left_out: tuple[str, ...]
    """Bodies with mass that a joint beside the chain to the tool moves, as of a linkage."""


def serial_bodies(model: RobotModel, robot: Robot) -> SerialBodies:
    """Bodies on the D-H links of the robot that the model is the hardware of, springs at rest.

    Raises:
        ValueError: the chain of the model to its tool has another number of joints.
    """
    document = mjcf_document(model.mj, model_name(model.mj))
    groups, left_out = _groups(document, chain(document, None, "tool0"))
    if len(groups) != robot.n_joints:
        raise ValueError(f"{robot.name} has {robot.n_joints} joints, its model {len(groups)}")
    frames, parts = link_frames(robot, np.zeros(robot.n_joints)), iter(groups)
    pairs = zip(robot.links, frames, strict=True)
    bodies = (summed(next(parts), F) if link.moves else Body(mass=0) for link, F in pairs)
    return SerialBodies(tuple(bodies), tuple(left_out))


def _groups(
    document: Document, joints: tuple[UrdfJoint, ...]
) -> tuple[list[list[Part]], list[str]]:
    """Parts that move with each joint of the chain, and links that move beside it."""
    on_chain, below = {joint.name for joint in joints}, children(document)
    groups, left_out, T = list[list[Part]](), list[str](), np.eye(4)
    for joint in joints:
        T = T @ joint.origin
        if joint.kind is not Kind.FIXED:
            groups.append([])
        open_ends = [(joint.child, T, False)]
        while open_ends:
            link, place, beside = open_ends.pop()
            if isinstance(inertial := document.links[link], Inertial):
                if beside:
                    left_out.append(link)
                elif groups:
                    groups[-1].append((place, inertial))
            for other in below[link]:
                if other.name not in on_chain:
                    moves = beside or other.kind is not Kind.FIXED
                    open_ends.append((other.child, place @ other.origin, moves))
    return groups, left_out
