"""Rotation matrices and their representations as SymPy formulas. Thesis (3.9)-(3.14).

To a matrix: exact for all values. From a matrix: the formula of the regular case; where its
representation is singular the arguments of an atan2 vanish together, see `rotation`.
"""

from typing import Any

import sympy as sp

from .symbols import Expression, SymbolicMatrix

Triple = tuple[Expression, Expression, Expression]


def about_x(angle: Any) -> SymbolicMatrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[1, 0, 0], [0, c, -s], [0, s, c]])


def about_y(angle: Any) -> SymbolicMatrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def about_z(angle: Any) -> SymbolicMatrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def skew(v: Any) -> SymbolicMatrix:
    """S(v) with S(v) u = v x u. Thesis (3.32)."""
    x, y, z = v
    return sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def from_axis_angle(axis: Any, angle: Any) -> SymbolicMatrix:
    """R_{k,theta} of a unit axis. Thesis (3.9)."""
    K = skew(axis)
    return sp.eye(3) + sp.sin(angle) * K + (1 - sp.cos(angle)) * K * K


def to_axis_angle(R: SymbolicMatrix) -> tuple[SymbolicMatrix, Expression]:
    """Unit axis and angle; singular at angles 0 and pi."""
    twice = sp.Matrix([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    length = sp.sqrt(twice.dot(twice))
    return twice / length, sp.atan2(length, R.trace() - 1)


def from_euler_zyz(phi: Any, theta: Any, psi: Any) -> SymbolicMatrix:
    """R_z(phi) R_y(theta) R_z(psi). Thesis (3.10)."""
    return about_z(phi) * about_y(theta) * about_z(psi)


def to_euler_zyz(R: SymbolicMatrix) -> Triple:
    """(phi, theta, psi), theta in (0, pi); singular at theta 0 and pi."""
    return (
        sp.atan2(R[1, 2], R[0, 2]),
        sp.atan2(sp.sqrt(R[0, 2] ** 2 + R[1, 2] ** 2), R[2, 2]),
        sp.atan2(R[2, 1], -R[2, 0]),
    )


def from_roll_pitch_yaw(roll: Any, pitch: Any, yaw: Any) -> SymbolicMatrix:
    """R_z(roll) R_y(pitch) R_x(yaw). Thesis (3.11)."""
    return about_z(roll) * about_y(pitch) * about_x(yaw)


def to_roll_pitch_yaw(R: SymbolicMatrix) -> Triple:
    """(roll, pitch, yaw), pitch in (-pi/2, pi/2); singular at its ends."""
    return (
        sp.atan2(R[1, 0], R[0, 0]),
        sp.atan2(-R[2, 0], sp.sqrt(R[0, 0] ** 2 + R[1, 0] ** 2)),
        sp.atan2(R[2, 1], R[2, 2]),
    )


def from_quaternion(q: Any) -> SymbolicMatrix:
    """R of a unit quaternion (w, x, y, z). Thesis (3.14)."""
    w, x, y, z = q
    K = skew((x, y, z))
    return sp.eye(3) + 2 * w * K + 2 * K * K


def to_quaternion(R: SymbolicMatrix) -> SymbolicMatrix:
    """Unit quaternion with w > 0; the formula fails at half turns, where w = 0."""
    w = sp.sqrt(1 + R.trace()) / 2
    twice = sp.Matrix([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return sp.Matrix([w, *(twice / (4 * w))])
