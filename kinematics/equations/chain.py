"""A robot as axes and arms: what every recursion over the links walks along.

Each link is four elementary motions in the order of its convention; rotations about x end an
axis system, so parallel axes share one and their angles add up before any cosine is taken.
"""

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from ..dh import Convention, Joint, Link, Robot
from ..expressions.exact import Expression, exact, exact_angle

Vector = tuple[Expression, Expression, Expression]
Naming = Callable[[Expression], Expression]


@dataclass(frozen=True)
class Axis:
    """A joint axis in base coordinates, and the way to it from the axis before."""

    joint: Joint
    direction: Vector
    arm: Vector
    """From the point on the previous axis (the base origin first) to the point on this one."""


@dataclass(frozen=True)
class Chain:
    """All axes, then the tool: the last arm leads to it, `rotation` holds its x, y, z axes."""

    axes: tuple[Axis, ...]
    tool_arm: Vector
    rotation: tuple[Vector, Vector, Vector]
    """Columns of R_base_tool."""


def scaled(name: Naming, factor: Expression, v: Vector) -> Vector:
    return (name(factor * v[0]), name(factor * v[1]), name(factor * v[2]))


def added(name: Naming, u: Vector, v: Vector) -> Vector:
    return (name(u[0] + v[0]), name(u[1] + v[1]), name(u[2] + v[2]))


def combined(name: Naming, a: Expression, u: Vector, b: Expression, v: Vector) -> Vector:
    """a u + b v."""
    return (name(a * u[0] + b * v[0]), name(a * u[1] + b * v[1]), name(a * u[2] + b * v[2]))


def crossed(name: Naming, u: Vector, v: Vector) -> Vector:
    return (
        name(u[1] * v[2] - u[2] * v[1]),
        name(u[2] * v[0] - u[0] * v[2]),
        name(u[0] * v[1] - u[1] * v[0]),
    )


ZERO: Vector = (sp.S.Zero, sp.S.Zero, sp.S.Zero)


class _Walker:
    """Axis system (x, y, z), turned by `angle` about z; the arm walked since the last axis."""

    def __init__(self, name: Naming) -> None:
        self.name = name
        self.x: Vector = (sp.S.One, sp.S.Zero, sp.S.Zero)
        self.y: Vector = (sp.S.Zero, sp.S.One, sp.S.Zero)
        self.z: Vector = (sp.S.Zero, sp.S.Zero, sp.S.One)
        self.angle: Expression = sp.S.Zero
        self.arm = ZERO

    def turned(self) -> tuple[Vector, Vector]:
        """The x and y axes after the rotation by `angle`."""
        c, s = self.name(sp.cos(self.angle)), self.name(sp.sin(self.angle))
        return (
            combined(self.name, c, self.x, s, self.y),
            combined(self.name, -s, self.x, c, self.y),
        )

    def rotate_z(self, angle: Expression) -> None:
        self.angle += angle

    def translate_z(self, distance: Expression) -> None:
        if distance != 0:
            self.arm = added(self.name, self.arm, scaled(self.name, distance, self.z))

    def translate_x(self, distance: Expression) -> None:
        if distance != 0:
            self.arm = added(self.name, self.arm, scaled(self.name, distance, self.turned()[0]))

    def rotate_x(self, angle: Expression) -> None:
        if angle != 0:
            x, y = self.turned()
            c, s = self.name(sp.cos(angle)), self.name(sp.sin(angle))
            self.x, self.angle = x, sp.S.Zero
            self.y, self.z = (
                combined(self.name, c, y, s, self.z),
                combined(self.name, -s, y, c, self.z),
            )


def parameters(link: Link) -> tuple[Expression, Expression, Expression, Expression]:
    """theta, d, a, alpha as exact SymPy numbers or expressions."""
    return exact_angle(link.theta), exact(link.d), exact(link.a), exact_angle(link.alpha)


def joint_variables(robot: Robot, phi: tuple[Expression, ...]) -> tuple[Expression, ...]:
    """coupling @ phi + offset, exact. Thesis (4.10)."""
    kinds = [robot.links[index].joint for index in robot.moving]
    result = []
    for kind, row, constant in zip(kinds, robot.coupling, robot.offset, strict=True):
        shift = exact_angle(constant) if kind is Joint.REVOLUTE else exact(constant)
        result.append(sp.Add(shift, *(exact(k) * p for k, p in zip(row, phi, strict=True) if k)))
    return tuple(result)


def walk(robot: Robot, q: tuple[Expression, ...], name: Naming) -> Chain:
    """Axes and arms at joint variables q, intermediates named by `name`."""
    walker = _Walker(name)
    axes: list[Axis] = []
    variables = iter(q)
    for link in robot.links:
        theta, d, a, alpha = parameters(link)
        variable = next(variables) if link.moves else sp.S.Zero
        if robot.convention is Convention.MODIFIED:
            walker.rotate_x(alpha)
            walker.translate_x(a)
        walker.rotate_z(theta + (variable if link.joint is Joint.REVOLUTE else 0))
        walker.translate_z(d + (variable if link.joint is Joint.PRISMATIC else 0))
        if link.moves:
            axes.append(Axis(link.joint, walker.z, walker.arm))
            walker.arm = ZERO
        if robot.convention is Convention.STANDARD:
            walker.translate_x(a)
            walker.rotate_x(alpha)
    x, y = walker.turned()
    return Chain(tuple(axes), walker.arm, (x, y, walker.z))
