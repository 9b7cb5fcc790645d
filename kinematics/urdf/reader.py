"""A URDF file as a Denavit-Hartenberg robot with limits and, where given, masses."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.arrays import Array

from ..dh import Joint, Robot
from ..equations.inertial_model import Body, InertialModel
from ..limits import Limits
from .bodies import summed
from .chain import chain, children
from .document import read_document
from .elements import Document, Fault, Inertial, Kind, UrdfJoint
from .table import Axis, table


@dataclass(frozen=True)
class UrdfArm:
    """A chain of a URDF file; joint variables are those of the file, in order from the base."""

    robot: Robot
    limits: Limits
    joints: tuple[str, ...]
    """Names of the moving joints."""
    bodies: tuple[Body, ...] | None
    """One for each link of the robot. None where the file has no masses, or where a joint beside
    the chain moves masses that no serial arm has."""

    def inertial_model(self) -> InertialModel:
        """The robot with its bodies, without drives.

        Raises:
            ValueError: there are no bodies.
        """
        if self.bodies is None:
            raise ValueError(f"{self.robot.name} has no masses, or some beside its chain that move")
        return InertialModel(self.robot, self.bodies)


def read_urdf(file: Path, base: str | None = None, tip: str | None = None) -> UrdfArm:
    """The chain from the base link to the tip link of a file, as a robot of the base's axes.

    base, tip: names of links; the root, and the end of the tree where it has only one.

    Raises:
        ValueError: the file is damaged, or its chain no serial arm; names file and element.
        OSError: the file cannot be read.
    """
    try:
        return arm_of(read_document(file), base, tip)
    except (ValueError, TypeError, RecursionError) as error:
        raise ValueError(f"{file.name}: {' '.join(str(error).split())}") from error


def arm_of(document: Document, base: str | None = None, tip: str | None = None) -> UrdfArm:
    """The chain from the base link to the tip link of a document; raises as `chain`."""
    joints = chain(document, base, tip)
    T, axes, places = np.eye(4), [], [(joints[0].parent, np.eye(4))]
    for joint in joints:
        T = T @ joint.origin
        places.append((joint.child, T))
        if joint.kind is not Kind.FIXED:
            kind = Joint.PRISMATIC if joint.kind is Kind.PRISMATIC else Joint.REVOLUTE
            axes.append(Axis(kind, T[:3, 3], T[:3, :3] @ joint.axis))
    links, frames = table(axes, T)
    robot = Robot(links, name=document.name)
    moving = [joint for joint in joints if joint.kind is not Kind.FIXED]
    limits = Limits(
        lower=tuple(joint.range[0] for joint in moving),
        upper=tuple(joint.range[1] for joint in moving),
        speed=tuple(joint.speed for joint in moving),
    )
    bodies = _bodies(document, joints, places, robot, frames)
    return UrdfArm(robot, limits, tuple(joint.name for joint in moving), bodies)


def _bodies(
    document: Document,
    joints: tuple[UrdfJoint, ...],
    places: list[tuple[str, Array]],
    robot: Robot,
    frames: list[Array],
) -> tuple[Body, ...] | None:
    """Bodies of the robot's links; what is fixed to the base moves nothing and is left out.

    Raises ValueError for a wrong inertial of a link that the chain moves.
    """
    on_chain, below = {joint.name for joint in joints}, children(document)
    groups: list[list[tuple[Array, Inertial]]] = [[]]
    for number, (name, T) in enumerate(places):
        if number and joints[number - 1].kind is not Kind.FIXED:
            groups.append([])
        fixed = [(name, T)]
        while fixed:
            link, place = fixed.pop()
            inertial = document.links[link]
            if isinstance(inertial, Fault) and len(groups) > 1:
                raise ValueError(inertial.sentence)
            if isinstance(inertial, Inertial):
                groups[-1].append((place, inertial))
            for joint in below[link]:
                if joint.name in on_chain:
                    continue
                if joint.kind is not Kind.FIXED:
                    return None
                fixed.append((joint.child, place @ joint.origin))
    if not any(groups[1:]):
        return None
    moving = iter(zip(groups[1:], frames, strict=True))
    return tuple(summed(*next(moving)) if link.moves else Body(mass=0) for link in robot.links)
