"""Vector algebra on named intermediates: each element of a result is named by a tape."""

from collections.abc import Callable, Sequence

import sympy as sp

from ..expressions.exact import Expression, SymbolicMatrix

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
    """M v for a constant 3 x 3 matrix."""
    rows = [name(sp.Add(*(name(M[i, j]) * v[j] for j in range(3)))) for i in range(3)]
    return (rows[0], rows[1], rows[2])


def tensor_times(name: Naming, tensor: Sequence[Expression], v: Vector) -> Vector:
    """I v for a tensor (xx, xy, xz, yy, yz, zz)."""
    xx, xy, xz, yy, yz, zz = tensor
    return (
        name(xx * v[0] + xy * v[1] + xz * v[2]),
        name(xy * v[0] + yy * v[1] + yz * v[2]),
        name(xz * v[0] + yz * v[1] + zz * v[2]),
    )


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
