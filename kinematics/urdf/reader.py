"""A URDF file as a Denavit-Hartenberg robot with limits and, where given, masses.

A link leads from one axis to the next along their common normal. The first goes from the z-axis of
the base to axis 1 and the last two from axis n to the tip, so that base and tip frames are kept.
Where two axes are nearly parallel their normal is far away: one constant link more goes by way
of an axis at right angles. Standard convention, thesis (3.27).
"""

from dataclasses import dataclass, replace
from math import atan2, pi
from pathlib import Path

import numpy as np

from armside.arrays import Array

from .. import rigid
from ..dh import Joint, Limits, Link, Robot, check_unit
from ..equations.inertial_model import Body, InertialModel
from ..rigid import link_transform
from .document import read_document
from .links_and_joints import Document, Fault, Inertial, Kind, UrdfJoint, chain, children, summed

SPEED = pi
"""[rad/s or m/s] of a joint without a greatest speed, as in a robot file."""
_PARALLEL = 1e-12  # sine between axes that counts as zero
_NEARLY = 1e-3  # sine below which the common normal may be a thousand arm lengths away


@dataclass(frozen=True)
class Axis:
    """Axis of a joint at zero in base axes: joint type, a point (3,) and a unit vector (3,)."""

    joint: Joint
    point: Array
    direction: Array


def table(axes: list[Axis], tip: Array) -> tuple[tuple[Link, ...], list[Array]]:
    """Links of a chain with T_base_tip (4, 4) at zero, and the frames of its moving links."""
    kinds = [Joint.FIXED, *(axis.joint for axis in axes)]
    following = [*axes, Axis(Joint.FIXED, tip[:3, 3], tip[:3, 2])]
    F, links, frames = np.eye(4), [], []
    for kind, axis in zip(kinds, following, strict=True):
        towards = axis
        if _PARALLEL < _sine(F, axis) < _NEARLY:  # a line at right angles on the way
            foot = axis.point - F[:3, 2] * (F[:3, 2] @ (axis.point - F[:3, 3]))
            towards = Axis(kind, foot, F[:3, 0])
        here = [_normal(F, towards, kind)]
        F = F @ link_transform(here[0])
        if kind is not Joint.FIXED:
            frames.append(F)
        if _sine(F, axis) > _PARALLEL:  # an axis at right angles stands between them
            here.append(_normal(F, axis, Joint.FIXED))
            F = F @ link_transform(here[-1])
        links += [link for link in here if link != Link(joint=Joint.FIXED)]
    rest = rigid.inverse(F) @ tip
    theta, d, last = atan2(rest[1, 0], rest[0, 0]), rest[2, 3], links[-1]
    if last.moves and float(last.a) == float(last.alpha) == 0:  # the tip's z-axis is axis n
        links[-1] = replace(last, theta=float(last.theta) + theta, d=float(last.d) + d)
        frames[-1] = tip
    else:
        links.append(Link(theta=theta, d=d, joint=Joint.FIXED))
    return tuple(links), frames


def _sine(F: Array, axis: Axis) -> float:
    return float(np.linalg.norm(np.cross(F[:3, 2], axis.direction)))


def _normal(F: Array, axis: Axis, kind: Joint) -> Link:
    """The link from the z-axis of F (4, 4) to an axis along their common normal."""
    R = F[:3, :3]
    u, p = R.T @ axis.direction, R.T @ (axis.point - F[:3, 3])
    sine = float(np.hypot(u[0], u[1]))
    if sine > _PARALLEL:
        x = np.array([-u[1], u[0]]) / sine  # z cross u
        a = float(x @ p[:2])
        along = (p[0] * u[0] + p[1] * u[1]) / sine**2  # of the point, beyond the normal's foot
        return Link(atan2(x[1], x[0]), p[2] - along * u[2], a, atan2(sine, u[2]), kind)
    a = float(np.hypot(p[0], p[1]))
    theta, a = (atan2(p[1], p[0]), a) if a > _PARALLEL else (0.0, 0.0)
    return Link(theta, 0.0, a, 0.0 if u[2] > 0 else np.pi, kind)


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
    without_speed: tuple[str, ...] = ()
    """Names of moving joints whose greatest speed the file has as 0 or not at all: `SPEED`."""

    def inertial_model(self) -> InertialModel:
        """The robot with its bodies, without drives.

        Raises ValueError: there are no bodies.
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
    for joint in moving:
        quantity = "slide" if joint.kind is Kind.PRISMATIC else "range"
        for end, value in zip(("lower", "upper"), joint.range, strict=True):
            check_unit(f"joint {joint.name!r}: limit {end}", quantity, value)
    lower, upper = zip(*(joint.range for joint in moving), strict=True)
    speed = tuple(SPEED if joint.speed is None else joint.speed for joint in moving)
    limits = Limits(lower=lower, upper=upper, speed=speed)
    bodies = _bodies(document, joints, places, robot, frames)
    names = tuple(joint.name for joint in moving)
    without_speed = tuple(joint.name for joint in moving if joint.speed is None)
    return UrdfArm(robot, limits, names, bodies, without_speed)


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
