"""URDF and MJCF of a robot of numbers: joints, frames, limits and, where given, masses.

One link a joint, whose frame is just after the joint. Neither format knows a coupling of motors:
joints are the joint variables less their offset, so that all of them at zero is phi = 0, and the
coupling is stated in a comment. The MJCF is a plain model, without drives, springs and sensors.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..dh import Convention, Joint, Limits, Link, Robot
from ..equations.inertial_model import Body
from ..rigid import link_transform
from ..rotation import to_quaternion, to_roll_pitch_yaw
from ..urdf.links_and_joints import Inertial, summed


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


_UNLIMITED = 1e6  # [N m] or [rad/s]: URDF wants a number where a kinematic model has none
_MASSES = "     Masses move with the joints; rotors, and what is fixed to the base, are left out."
_NO_MASSES = "     No masses are known to this model."


def urdf(
    robot: Robot,
    limits: Limits | None = None,
    bodies: Sequence[Body] = (),
    notes: Sequence[str] = (),
) -> str:
    """URDF text: links base_link, link_1 ... link_n, tool0; joints joint_1 ... joint_n.

    bodies: one for each link of the robot, as in an `InertialModel`.
    notes: further lines of the comment at the head.

    Raises:
        ValueError: a D-H parameter or a body is symbolic.
    """
    found, tool = segments(robot, bodies)
    name = re.sub(r"[^a-z0-9_.-]", "_", robot.name.lower())
    lines = [
        '<?xml version="1.0"?>',
        f"<!-- Generated by armside from a {robot.convention.value} Denavit-Hartenberg table.",
        *coupling_notes(robot),
        *(f"     {note.replace('--', '- -')}" for note in notes),
        _MASSES if bodies else _NO_MASSES,
        "     Efforts are not known to a kinematic model: they are written as no limit. -->",
        f'<robot name="{name}">',
        '  <link name="base_link"/>',
    ]
    for number, (segment, limit) in enumerate(zip(found, _limits(robot, limits), strict=True), 1):
        joint, link = f"joint_{number}", f"link_{number}"
        parent = f"link_{number - 1}" if number > 1 else "base_link"
        moves = ['    <axis xyz="0 0 1"/>', limit]
        lines += _joint(joint, segment.joint.value, (parent, link), segment.place, moves)
        lines += _link(link, segment.body)
    lines += _joint("tool0_joint", "fixed", (f"link_{len(found)}", "tool0"), tool, [])
    return "\n".join([*lines, *_link("tool0", Body(mass=0)), "</robot>", ""])


def _limits(robot: Robot, limits: Limits | None) -> list[str]:
    """The limit element of each joint."""
    if limits is None:
        bounds, speeds = [(-math.pi, math.pi)] * robot.n_joints, (_UNLIMITED,) * robot.n_joints
    else:
        bounds, speeds = ranges(robot, limits), limits.speed
    return [
        f'    <limit lower="{low!r}" upper="{up!r}" velocity="{v!r}" effort="{_UNLIMITED:g}"/>'
        for (low, up), v in zip(bounds, speeds, strict=True)
    ]


def _joint(
    name: str, kind: str, ends: tuple[str, str], place: Array, moves: Sequence[str]
) -> list[str]:
    yaw, pitch, roll = to_roll_pitch_yaw(place[:3, :3])  # URDF: fixed axes x, y, z
    return [
        f'  <joint name="{name}" type="{kind}">',
        f'    <parent link="{ends[0]}"/>',
        f'    <child link="{ends[1]}"/>',
        f'    <origin xyz="{_words(place[:3, 3])}" rpy="{_words((roll, pitch, yaw))}"/>',
        *moves,
        "  </joint>",
    ]


def _link(name: str, body: Body) -> list[str]:
    if float(body.mass) == 0:
        return [f'  <link name="{name}"/>']
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    pairs = zip(names, map(float, body.inertia), strict=True)
    inertia = " ".join(f'{name}="{value!r}"' for name, value in pairs)
    return [
        f'  <link name="{name}">',
        "    <inertial>",
        f'      <origin xyz="{_words(body.com)}"/>',
        f'      <mass value="{float(body.mass)!r}"/>',
        f"      <inertia {inertia}/>",
        "    </inertial>",
        "  </link>",
    ]


def _words(values) -> str:
    return " ".join(repr(float(value)) for value in values)


_LEAST = 1e-9  # [kg] and [kg m^2]: MuJoCo moves no body without mass
_TYPES = {Joint.REVOLUTE: "hinge", Joint.PRISMATIC: "slide"}


def mjcf(
    robot: Robot,
    limits: Limits | None = None,
    bodies: Sequence[Body] = (),
    notes: Sequence[str] = (),
) -> str:
    """MJCF text: bodies base_link, link_1 ... link_n; joints joint_1 ... joint_n; site tool0.

    bodies: one for each link of the robot, as in an `InertialModel`.
    notes: further lines of the comment at the head.

    Raises:
        ValueError: a D-H parameter or a body is symbolic.
    """
    found, tool = segments(robot, bodies)
    name = re.sub(r"[^a-z0-9_.-]", "_", robot.name.lower())
    bounds = ranges(robot, limits) if limits else [None] * len(found)
    lines = [
        f"<!-- Generated by armside from a {robot.convention.value} Denavit-Hartenberg table.",
        *coupling_notes(robot),
        *(f"     {note.replace('--', '- -')}" for note in notes),
        f"     Bodies whose mass is not known have {_LEAST:g} kg. -->",
        f'<mujoco model="{name}">',
        '  <compiler angle="radian" autolimits="true" inertiafromgeom="false" '
        f'boundmass="{_LEAST:g}" boundinertia="{_LEAST:g}"/>',
        '  <option gravity="0 0 -9.82"/>',
        "  <worldbody>",
        '    <body name="base_link">',
    ]
    for number, (segment, bound) in enumerate(zip(found, bounds, strict=True), 1):
        lines += _body(number, segment, bound)
    place = _place(tool)
    lines.append(f'{_indent(len(found) + 1)}<site name="tool0" {place}/>')
    lines += [f"{_indent(depth)}</body>" for depth in range(len(found), -1, -1)]
    return "\n".join([*lines, "  </worldbody>", "</mujoco>", ""])


def _body(number: int, segment: Segment, bound: tuple[float, float] | None) -> list[str]:
    outer, inner = _indent(number), _indent(number + 1)
    lines = [f'{outer}<body name="link_{number}" {_place(segment.place)}>']
    if float(segment.body.mass) > 0:
        com, inertia = _words(segment.body.com), _words(segment.body.inertia)
        mass = float(segment.body.mass)
        lines.append(f'{inner}<inertial pos="{com}" mass="{mass!r}" fullinertia="{inertia}"/>')
    limited = f' range="{_words(bound)}"' if bound else ""
    kind = _TYPES[segment.joint]
    joint = f'<joint name="joint_{number}" type="{kind}" axis="0 0 1"{limited}/>'
    return [*lines, f"{inner}{joint}"]


def _indent(depth: int) -> str:
    return "  " * (depth + 2)


def _place(T: Array) -> str:
    return f'pos="{_words(T[:3, 3])}" quat="{_words(to_quaternion(T[:3, :3]))}"'
