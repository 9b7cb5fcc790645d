"""A robot as joints and rigid groups of bodies, each in axes that move with it.

Body frame i is the frame just after joint i has moved. Between body frame i - 1 and joint i lies a
constant transform; for the usual twists of +-90 degrees it costs no arithmetic at all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from ..dh import Convention, Joint, Robot
from ..expressions.exact import Expression, SymbolicMatrix, exact
from ..expressions.rotation_symbolic import about_x, about_z
from .chain import ZERO, Vector, added, crossed, parameters, scaled
from .inertial_model import Body
from .program import Tape


def settled(expression: Any) -> Expression:
    """A constant as a fraction where it is one, else as a float; symbols stay."""
    expression = sp.sympify(expression)
    if expression.is_number and not expression.is_Rational:
        return sp.Float(expression.evalf(17), 17)
    return expression


@dataclass(frozen=True)
class Inertia:
    """Mass, first moment and inertia about the origin of a frame: linear in all its numbers."""

    mass: Expression
    moment: Vector
    tensor: tuple[Expression, ...]
    """xx, xy, xz, yy, yz, zz"""

    @property
    def elements(self) -> tuple[Expression, ...]:
        return (self.mass, *self.moment, *self.tensor)


@dataclass(frozen=True)
class Segment:
    """The way from body frame i - 1 to body frame i, and what moves with frame i."""

    joint: Joint
    turn: SymbolicMatrix
    """Constant rotation R_{i-1, joint}."""
    shift: SymbolicMatrix
    """Constant translation, in body frame i - 1."""
    constant: Expression
    """Added to the joint variable."""
    inertia: Inertia


@dataclass(frozen=True)
class Tree:
    """All segments, and the constant transform from the last body frame to the tool frame."""

    segments: tuple[Segment, ...]
    tool_turn: SymbolicMatrix
    tool_shift: SymbolicMatrix


class _Placement:
    """A constant transform that grows by elementary motions."""

    def __init__(self) -> None:
        self.R, self.p = sp.eye(3), sp.zeros(3, 1)

    def rotate(self, R: SymbolicMatrix) -> None:
        self.R = (self.R * R).applyfunc(settled)

    def translate(self, x: Any, z: Any) -> None:
        self.p = (self.p + self.R * sp.Matrix([x, 0, z])).applyfunc(settled)


def tree(robot: Robot, bodies: Sequence[Body] = ()) -> Tree:
    """Segments of a robot; without bodies everything weighs nothing."""
    joints: list[tuple[Joint, SymbolicMatrix, SymbolicMatrix, Expression]] = []
    groups: list[list[Expression]] = []
    place = _Placement()
    for number, link in enumerate(robot.links):
        theta, d, a, alpha = parameters(link)
        if robot.convention is Convention.MODIFIED:
            place.rotate(about_x(alpha))
            place.translate(a, 0)
        constant, rise = theta, d
        if link.joint is not Joint.REVOLUTE:
            place.rotate(about_z(theta))
            constant = d
        if link.moves:
            joints.append((link.joint, place.R, place.p, constant))
            groups.append([sp.S.Zero] * 10)
            place = _Placement()
        if link.joint is not Joint.PRISMATIC:
            place.translate(0, rise)
        if robot.convention is Convention.STANDARD:
            place.translate(a, 0)
            place.rotate(about_x(alpha))
        if bodies and groups:
            moved = _placed(bodies[number], place)
            groups[-1] = [u + v for u, v in zip(groups[-1], moved, strict=True)]
    segments = tuple(
        Segment(*joint, _inertia(group)) for joint, group in zip(joints, groups, strict=True)
    )
    return Tree(segments, place.R, place.p)


def _inertia(elements: Sequence[Any]) -> Inertia:
    values = tuple(map(settled, elements))
    return Inertia(values[0], values[1:4], values[4:])


def _placed(body: Body, place: _Placement) -> tuple[Expression, ...]:
    """Mass, first moment and inertia about the body frame's origin, in its axes."""
    m, c = exact(body.mass), place.p + place.R * sp.Matrix([exact(v) for v in body.com])
    xx, yy, zz, xy, xz, yz = map(exact, body.inertia)
    tensor = place.R * sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) * place.R.T
    about = tensor + m * (c.dot(c) * sp.eye(3) - c * c.T)
    return (m, *(m * c), *(about[i, j] for i in range(3) for j in range(i, 3)))


def symbolic_inertias(n: int) -> list[Inertia]:
    """Inertias of n groups as symbols m1, hx1 ... Izz1, m2 ...: the parameters Theta of (2.17)."""
    names = ("m", "hx", "hy", "hz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
    return [
        _inertia([sp.Symbol(f"{name}{i}", real=True) for name in names]) for i in range(1, n + 1)
    ]


@dataclass(frozen=True)
class Step:
    """One joint at its joint variable: rotation and translation from frame i to frame i - 1."""

    segment: Segment
    cosine: Expression
    sine: Expression
    shift: Vector

    def out(self, tape: Tape, v: Vector) -> Vector:
        """Frame i axes to frame i - 1 axes."""
        c, s = self.cosine, self.sine
        turned = (tape(c * v[0] - s * v[1]), tape(s * v[0] + c * v[1]), v[2])
        return times(tape, self.segment.turn, turned)

    def into(self, tape: Tape, v: Vector) -> Vector:
        """Frame i - 1 axes to frame i axes."""
        c, s = self.cosine, self.sine
        x, y, z = times(tape, self.segment.turn.T, v)
        return (tape(c * x + s * y), tape(c * y - s * x), z)


def steps(tree: Tree, q: Sequence[Expression], tape: Tape) -> list[Step]:
    """All joints at their variables."""
    result = []
    for segment, variable in zip(tree.segments, q, strict=True):
        value = segment.constant + variable
        shift: Vector = tuple(segment.shift)
        if segment.joint is Joint.REVOLUTE:
            cosine, sine = tape(sp.cos(value)), tape(sp.sin(value))
        else:
            cosine, sine = sp.S.One, sp.S.Zero
            shift = added(tape, shift, scaled(tape, tape(value), tuple(segment.turn[:, 2])))
        result.append(Step(segment, cosine, sine, shift))
    return result


def times(tape: Tape, M: SymbolicMatrix, v: Vector) -> Vector:
    rows = [tape(sp.Add(*(tape(M[i, j]) * v[j] for j in range(3)))) for i in range(3)]
    return (rows[0], rows[1], rows[2])


def swept(tape: Tape, omega: Vector, alpha: Vector, arm: Vector) -> Vector:
    """alpha x arm + omega x (omega x arm)."""
    inner = crossed(tape, omega, arm)
    return added(tape, crossed(tape, alpha, arm), crossed(tape, omega, inner))


@dataclass(frozen=True)
class State:
    """Motion of a body frame in its own axes; the acceleration is that of its origin."""

    omega: Vector
    alpha: Vector
    a: Vector


def forward(
    tape: Tape,
    steps: Sequence[Step],
    rates: Sequence[Expression],
    accelerations: Sequence[Expression],
    base_acceleration: Vector,
) -> list[State]:
    """Motion of each body frame from joint rates and accelerations, base first."""
    state = State(ZERO, ZERO, base_acceleration)
    states = []
    for step, rate, rate_dot in zip(steps, rates, accelerations, strict=True):
        a = added(tape, state.a, swept(tape, state.omega, state.alpha, step.shift))
        omega, alpha = step.into(tape, state.omega), step.into(tape, state.alpha)
        a = step.into(tape, a)
        if step.segment.joint is Joint.REVOLUTE:
            alpha = (
                tape(alpha[0] + omega[1] * rate),
                tape(alpha[1] - omega[0] * rate),
                tape(alpha[2] + rate_dot),
            )
            omega = (omega[0], omega[1], tape(omega[2] + rate))
        else:
            a = (
                tape(a[0] + 2 * omega[1] * rate),
                tape(a[1] - 2 * omega[0] * rate),
                tape(a[2] + rate_dot),
            )
        state = State(omega, alpha, a)
        states.append(state)
    return states
