"""A robot as a chain of joints and rigid bodies, each in axes that move with it.

Body frame i is the frame just after joint i has moved. Between body frame i - 1 and joint i lies a
constant transform; for the usual twists of +-90 degrees it costs no arithmetic at all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from ..dh import Convention, Joint, Robot
from ..expressions.rotation_symbolic import about_x, about_z
from ..expressions.symbols import Expression, SymbolicMatrix, exact, internal
from .chain import (
    ZERO,
    Vector,
    added,
    exact_parameters,
    lever_acceleration,
    scaled,
    symmetric,
    times,
    upper,
)
from .inertial_model import Body
from .program import Tape


def simplified_constant(expression: Any) -> Expression:
    """A constant as a fraction if it is one, else as a float; symbols stay."""
    expression = sp.sympify(expression)
    if expression.is_number and not expression.is_Rational:
        return sp.Float(expression.evalf(17), 17)
    return expression


@dataclass(frozen=True)
class Inertia:
    """Mass, first moment and tensor (xx, xy, xz, yy, yz, zz) about the origin of a frame."""

    mass: Expression
    moment: Vector
    tensor: tuple[Expression, ...]

    @property
    def elements(self) -> tuple[Expression, ...]:
        """All ten numbers: mass, moment, tensor."""
        return (self.mass, *self.moment, *self.tensor)


@dataclass(frozen=True)
class Segment:
    """Constant transform from body frame i - 1 to joint i, and the body that moves with frame i."""

    joint: Joint
    rotation: SymbolicMatrix
    translation: SymbolicMatrix
    constant: Expression
    """Added to the joint variable."""
    inertia: Inertia


@dataclass(frozen=True)
class BodyChain:
    """All segments, and the constant transform from the last body frame to the tool frame."""

    segments: tuple[Segment, ...]
    tool_rotation: SymbolicMatrix
    tool_translation: SymbolicMatrix


class _Placement:
    """A constant transform that grows by elementary motions."""

    def __init__(self) -> None:
        self.R, self.p = sp.eye(3), sp.zeros(3, 1)

    def rotate(self, R: SymbolicMatrix) -> None:
        self.R = (self.R * R).applyfunc(simplified_constant)

    def translate(self, x: Any, z: Any) -> None:
        self.p = (self.p + self.R * sp.Matrix([x, 0, z])).applyfunc(simplified_constant)


def body_chain(robot: Robot, bodies: Sequence[Body] = ()) -> BodyChain:
    """Segments of a robot, massless without bodies."""
    joints: list[tuple[Joint, SymbolicMatrix, SymbolicMatrix, Expression]] = []
    groups: list[list[Expression]] = []
    place = _Placement()
    for number, link in enumerate(robot.links):
        theta, d, a, alpha = exact_parameters(link)
        if robot.convention is Convention.MODIFIED:
            place.rotate(about_x(alpha))
            place.translate(a, 0)
        constant = theta
        if link.joint is not Joint.REVOLUTE:
            place.rotate(about_z(theta))
            constant = d
        if link.moves:
            joints.append((link.joint, place.R, place.p, constant))
            groups.append([sp.S.Zero] * 10)
            place = _Placement()
        if link.joint is not Joint.PRISMATIC:
            place.translate(0, d)
        if robot.convention is Convention.STANDARD:
            place.translate(a, 0)
            place.rotate(about_x(alpha))
        if bodies and groups:
            moved = _placed(bodies[number], place)
            groups[-1] = [u + v for u, v in zip(groups[-1], moved, strict=True)]
    pairs = zip(joints, groups, strict=True)
    segments = tuple(Segment(*joint, _inertia(group)) for joint, group in pairs)
    return BodyChain(segments, place.R, place.p)


def _inertia(elements: Sequence[Any]) -> Inertia:
    values = tuple(map(simplified_constant, elements))
    return Inertia(values[0], values[1:4], values[4:])


def _placed(body: Body, place: _Placement) -> tuple[Expression, ...]:
    """Mass, first moment and inertia about the body frame's origin, in its axes."""
    m, c = exact(body.mass), place.p + place.R * sp.Matrix([exact(v) for v in body.com])
    xx, yy, zz, xy, xz, yz = map(exact, body.inertia)
    tensor = place.R * symmetric((xx, xy, xz, yy, yz, zz)) * place.R.T
    return (m, *(m * c), *upper(tensor + m * (c.dot(c) * sp.eye(3) - c * c.T)))


def symbolic_inertias(n: int) -> list[Inertia]:
    """Inertias of n groups as symbols m1, hx1 ... Izz1, m2 ...: the parameters Theta of (2.17)."""
    names = ("m", "hx", "hy", "hz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
    return [_inertia([internal(f"{name}{i}") for name in names]) for i in range(1, n + 1)]


@dataclass(frozen=True)
class JointTransform:
    """Rotation and translation from frame i to frame i - 1 at a value of the joint variable."""

    segment: Segment
    cosine: Expression
    sine: Expression
    translation: Vector

    @property
    def revolute(self) -> bool:
        """False for a prismatic joint."""
        return self.segment.joint is Joint.REVOLUTE

    def out(self, tape: Tape, v: Vector) -> Vector:
        """Frame i axes to frame i - 1 axes."""
        c, s = self.cosine, self.sine
        rotated = (tape(c * v[0] - s * v[1]), tape(s * v[0] + c * v[1]), v[2])
        return times(tape, self.segment.rotation, rotated)

    def into(self, tape: Tape, v: Vector) -> Vector:
        """Frame i - 1 axes to frame i axes."""
        c, s = self.cosine, self.sine
        x, y, z = times(tape, self.segment.rotation.T, v)
        return (tape(c * x + s * y), tape(c * y - s * x), z)


def joint_transforms(chain: BodyChain, q: Sequence[Expression], tape: Tape) -> list[JointTransform]:
    """Transforms of all joints at joint variables q."""
    result = []
    for segment, variable in zip(chain.segments, q, strict=True):
        value = segment.constant + variable
        translation: Vector = tuple(segment.translation)
        if segment.joint is Joint.REVOLUTE:
            cosine, sine = tape(sp.cos(value)), tape(sp.sin(value))
        else:
            cosine, sine = sp.S.One, sp.S.Zero
            along = scaled(tape, tape(value), tuple(segment.rotation[:, 2]))
            translation = added(tape, translation, along)
        result.append(JointTransform(segment, cosine, sine, translation))
    return result


@dataclass(frozen=True)
class FrameMotion:
    """Motion of a body frame in its own axes; `a` is the acceleration of its origin."""

    omega: Vector
    alpha: Vector
    a: Vector


def forward(
    tape: Tape,
    chain: Sequence[JointTransform],
    rates: Sequence[Expression],
    accelerations: Sequence[Expression],
    base_acceleration: Vector,
) -> list[FrameMotion]:
    """Motion of each body frame from joint rates and accelerations, base first."""
    omega, alpha, a = ZERO, ZERO, base_acceleration
    motions = []
    for joint, rate, rate_dot in zip(chain, rates, accelerations, strict=True):
        a = added(tape, a, lever_acceleration(tape, omega, alpha, joint.translation))
        omega, alpha, a = joint.into(tape, omega), joint.into(tape, alpha), joint.into(tape, a)
        if joint.revolute:
            x, y = tape(alpha[0] + omega[1] * rate), tape(alpha[1] - omega[0] * rate)
            alpha = (x, y, tape(alpha[2] + rate_dot))
            omega = (omega[0], omega[1], tape(omega[2] + rate))
        else:
            x, y = tape(a[0] + 2 * omega[1] * rate), tape(a[1] - 2 * omega[0] * rate)
            a = (x, y, tape(a[2] + rate_dot))
        motions.append(FrameMotion(omega, alpha, a))
    return motions
