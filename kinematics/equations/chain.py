"""Joint axes of a robot and the vectors between them, in base coordinates.

Each link is four elementary motions in the order of its convention; rotations about x end an
axis system, so parallel axes share one and their angles add up before any cosine is taken. A tape
names each element of a vector that is computed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

from ..dh import Convention, Joint, Link
from ..expressions.symbols import Expression, SymbolicMatrix, exact, exact_angle

Vector = tuple[Expression, Expression, Expression]
Matrix = list[list[Expression]]
Naming = Callable[[Expression], Expression]

ZERO: Vector = (sp.S.Zero, sp.S.Zero, sp.S.Zero)
UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Indices of a tensor (xx, xy, xz, yy, yz, zz)."""


def scaled(name: Naming, factor: Expression, v: Vector) -> Vector:
    """factor v."""
    return (name(factor * v[0]), name(factor * v[1]), name(factor * v[2]))


def added(name: Naming, u: Vector, v: Vector) -> Vector:
    """u + v."""
    return (name(u[0] + v[0]), name(u[1] + v[1]), name(u[2] + v[2]))


def combined(name: Naming, a: Expression, u: Vector, b: Expression, v: Vector) -> Vector:
    """a u + b v."""
    return (name(a * u[0] + b * v[0]), name(a * u[1] + b * v[1]), name(a * u[2] + b * v[2]))


def crossed(name: Naming, u: Vector, v: Vector) -> Vector:
    """u x v."""
    return (
        name(u[1] * v[2] - u[2] * v[1]),
        name(u[2] * v[0] - u[0] * v[2]),
        name(u[0] * v[1] - u[1] * v[0]),
    )


def times(name: Naming, M: SymbolicMatrix, v: Vector) -> Vector:
    """M v for a 3 x 3 matrix."""
    x, y, z = (name(sp.Add(*(name(M[i, j]) * v[j] for j in range(3)))) for i in range(3))
    return x, y, z


def lever_acceleration(name: Naming, omega: Vector, alpha: Vector, arm: Vector) -> Vector:
    """Tangential and centripetal acceleration alpha x arm + omega x (omega x arm)."""
    inner = crossed(name, omega, arm)
    return added(name, crossed(name, alpha, arm), crossed(name, omega, inner))


def symmetric(tensor: Sequence[Expression]) -> SymbolicMatrix:
    """3 x 3 matrix of a tensor (xx, xy, xz, yy, yz, zz)."""
    xx, xy, xz, yy, yz, zz = tensor
    return sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def upper(M: SymbolicMatrix) -> tuple[Expression, ...]:
    """Elements (xx, xy, xz, yy, yz, zz) of a symmetric 3 x 3 matrix."""
    return tuple(M[i, j] for i, j in UPPER)


@dataclass(frozen=True)
class Axis:
    """A joint axis in base coordinates; its lever starts on the axis before (at the base first)."""

    joint: Joint
    direction: Vector
    lever: Vector


@dataclass(frozen=True)
class Chain:
    """All joint axes, the lever from the last to the tool origin, and columns of R_base_tool."""

    axes: tuple[Axis, ...]
    tool_lever: Vector
    rotation: tuple[Vector, Vector, Vector]


class _MovingFrame:
    """Axes (x, y, z) rotated by `angle` about z, and the translation since the last joint axis."""

    def __init__(self, name: Naming) -> None:
        self.name = name
        self.x, self.y, self.z = (tuple(row) for row in sp.eye(3).tolist())
        self.angle: Expression = sp.S.Zero
        self.lever = ZERO

    def rotated(self) -> tuple[Vector, Vector]:
        """The x and y axes after the rotation by `angle`."""
        name, c, s = self.name, self.name(sp.cos(self.angle)), self.name(sp.sin(self.angle))
        return combined(name, c, self.x, s, self.y), combined(name, -s, self.x, c, self.y)

    def translate_z(self, distance: Expression) -> None:
        if distance != 0:
            self.lever = added(self.name, self.lever, scaled(self.name, distance, self.z))

    def translate_x(self, distance: Expression) -> None:
        if distance != 0:
            x, _ = self.rotated()
            self.lever = added(self.name, self.lever, scaled(self.name, distance, x))

    def rotate_x(self, angle: Expression) -> None:
        if angle != 0:
            x, y = self.rotated()
            name, c, s = self.name, self.name(sp.cos(angle)), self.name(sp.sin(angle))
            self.x, self.angle = x, sp.S.Zero
            self.y, self.z = combined(name, c, y, s, self.z), combined(name, -s, y, c, self.z)


def exact_parameters(link: Link) -> tuple[Expression, Expression, Expression, Expression]:
    """theta, d, a, alpha as exact SymPy numbers or expressions."""
    return exact_angle(link.theta), exact(link.d), exact(link.a), exact_angle(link.alpha)


def joint_axes(
    links: Sequence[Link], convention: Convention, q: Sequence[Expression], name: Naming
) -> Chain:
    """Joint axes and end of links at joint variables q, intermediates named by `name`."""
    frame, axes, variables = _MovingFrame(name), list[Axis](), iter(q)
    for link in links:
        theta, d, a, alpha = exact_parameters(link)
        variable = next(variables) if link.moves else sp.S.Zero
        if convention is Convention.MODIFIED:
            frame.rotate_x(alpha)
            frame.translate_x(a)
        frame.angle += theta + (variable if link.joint is Joint.REVOLUTE else 0)
        frame.translate_z(d + (variable if link.joint is Joint.PRISMATIC else 0))
        if link.moves:
            axes.append(Axis(link.joint, frame.z, frame.lever))
            frame.lever = ZERO
        if convention is Convention.STANDARD:
            frame.translate_x(a)
            frame.rotate_x(alpha)
    x, y = frame.rotated()
    return Chain(tuple(axes), frame.lever, (x, y, frame.z))
