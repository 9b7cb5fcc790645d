"""A robot of numbers as a tree file sees it: one link a joint, whose frame is just after the joint.

Joints are the joint variables less their offset, so that all of them at zero is phi = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..dh import Convention, Joint, Link, Robot
from ..equations.inertial_model import Body
from ..limits import Limits
from ..links import link_transform
from ..urdf.bodies import summed
from ..urdf.elements import Inertial


@dataclass(frozen=True)
class Segment:
    """A joint about or along the z-axis of its frame, at `place` (4, 4) in the frame before, and
    the body that moves with it: its centre of mass and inertia are in the axes of that frame."""

    joint: Joint
    place: Array
    body: Body


def segments(robot: Robot, bodies: Sequence[Body] = ()) -> tuple[tuple[Segment, ...], Array]:
    """Segments from the base, and the tool (4, 4) in the last frame.

    bodies: one for each link as in an `InertialModel`; massless without. What is fixed to the base
    is left out.

    Raises:
        ValueError: a D-H parameter or a body is symbolic, or the bodies are not one for each link.
    """
    _check(robot, bodies)
    joints, parts = list[tuple[Joint, Array]](), list[list[tuple[Array, Inertial]]]()
    offsets, place = iter(robot.offset), np.eye(4)
    for number, link in enumerate(robot.links):
        offset = float(next(offsets)) if link.moves else 0.0
        screw, rod = _rotated(link, offset), _constant(a=link.a, alpha=link.alpha)
        if robot.convention is Convention.MODIFIED:
            place = place @ rod
        place = place @ screw
        if link.moves:
            joints.append((link.joint, place))
            parts.append([])
            place = np.eye(4)
        if link.joint is Joint.REVOLUTE:
            place = place @ _constant(d=link.d)
        if robot.convention is Convention.STANDARD:
            place = place @ rod
        if bodies and parts and float(bodies[number].mass) > 0:
            parts[-1].append((place, _inertial(bodies[number])))
    pairs = zip(joints, parts, strict=True)
    return tuple(Segment(*joint, summed(part, np.eye(4))) for joint, part in pairs), place


def ranges(robot: Robot, limits: Limits) -> list[tuple[float, float]]:
    """Range of each joint: that of its motor, or of its combination of motors if it has one."""
    found = list(zip(limits.lower, limits.upper, strict=True))
    for index, row in enumerate(robot.coupling):
        for bound in limits.coupled:
            if np.array_equal(bound.coefficients, row):
                found[index] = (bound.lower, bound.upper)
    return found


def coupling_notes(robot: Robot) -> list[str]:
    """Sentence joint_3 = phi_3 - phi_2, for each joint that is not its own motor."""
    lines = []
    for number, row in enumerate(robot.coupling, 1):
        if not np.array_equal(row, np.eye(robot.n_joints)[number - 1]):
            terms = [f"{k:+g} phi_{i}" for i, k in enumerate(row, 1) if k]
            lines.append(f"     Coupling: joint_{number} = {' '.join(terms)}, phi: motor angles.")
    return lines


def _rotated(link: Link, offset: float) -> Array:
    """The transform up to a joint at zero: without d of a revolute one, which comes after it."""
    if link.joint is Joint.REVOLUTE:
        return _constant(theta=float(link.theta) + offset)
    return _constant(theta=link.theta, d=float(link.d) + offset)


def _constant(**parameters) -> Array:
    return link_transform(Link(**parameters, joint=Joint.FIXED))


def _inertial(body: Body) -> Inertial:
    origin = np.eye(4)
    origin[:3, 3] = [float(value) for value in body.com]
    return Inertial(origin, body)


def _check(robot: Robot, bodies: Sequence[Body]) -> None:
    if robot.free_symbols:
        names = ", ".join(sorted(map(str, robot.free_symbols)))
        raise ValueError(f"needs a robot of numbers; {robot.name} has symbols: {names}")
    if bodies and len(bodies) != len(robot.links):
        raise ValueError(f"{robot.name} needs {len(robot.links)} bodies, got {len(bodies)}")
    values = [v for body in bodies for v in (body.mass, *body.com, *body.inertia)]
    if any(getattr(value, "free_symbols", ()) for value in values):
        raise ValueError(f"needs bodies of numbers; those of {robot.name} have symbols")
