"""Singular configurations: symbolic conditions and numeric measures. Thesis 3.4.4."""

from dataclasses import dataclass

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..arguments import real_array
from ..dh import Link, Robot
from ..equations.chain import exact_parameters
from ..expressions.exact import Expression
from ..inverse.wrist_arm import wrist_arm
from ..links import standard_links
from .procedures import jacobian, matrix_t


@dataclass(frozen=True)
class SingularConditions:
    """Expressions of the D-H joint variables theta that vanish where the arm is singular.

    Elbow: stretched or folded; shoulder: wrist centre on axis 1; wrist: axes 4 and 6 aligned.
    """

    elbow: Expression
    shoulder: Expression
    wrist: Expression


def decoupled_determinant(robot: Robot) -> tuple[Expression, Expression]:
    """(arm, wrist) factors of det J_theta at the wrist centre, in theta_2, theta_3 and theta_5.

    A spherical wrist makes J block triangular there, so det J = det J_11 det J_22. The first does
    not depend on the angle of axis 1, nor the second on those of axes 4 and 6: they are taken as 0.

    Raises:
        UnsolvableGeometryError: the wrist is not spherical, or the arm no elbow arm.
    """
    wrist_arm(robot)
    theta = [sp.Symbol(f"theta_{i}", real=True) if i in (2, 3, 5) else 0 for i in range(1, 7)]
    six = [link for link in standard_links(robot) if link.moves]
    pairs = zip(theta, six, strict=True)
    links = [Link(angle, *exact_parameters(link)[1:], link.joint) for angle, link in pairs]
    links[5] = Link()  # the tool moved to the wrist centre
    J = jacobian(links)
    wrist_axes = matrix_t(links)[3][:3, :3].T * J[3:, 3:]
    determinants = J[:3, :3].det(), wrist_axes.applyfunc(sp.trigsimp).det()
    arm, wrist = (sp.factor(sp.trigsimp(each)) for each in determinants)
    return arm, wrist


def conditions(robot: Robot) -> SingularConditions:
    """The three singularities of an elbow arm with a spherical wrist, as factors."""
    arm, wrist = decoupled_determinant(robot)
    bend = {sp.Symbol("theta_3", real=True)}
    factors = [f for f in sp.Mul.make_args(arm) if f.free_symbols]
    return SingularConditions(
        elbow=sp.Mul(*(f for f in factors if f.free_symbols == bend)),
        shoulder=sp.Mul(*(f for f in factors if f.free_symbols != bend)),
        wrist=wrist,
    )


def manipulability(J: ArrayLike) -> Array:
    """sqrt(det(J J^T)) of Jacobians (..., 6, n): zero if J has rank < 6, as all with n < 6."""
    J = real_array("J", J)
    if J.shape[-1] < J.shape[-2]:
        return np.zeros(J.shape[:-2])
    return np.prod(np.linalg.svd(J, compute_uv=False), axis=-1)


def distance_to_singularity(J: ArrayLike) -> Array:
    """Least singular value of Jacobians (..., 6, n), shape (...)."""
    values = np.linalg.svd(np.asarray(J, dtype=np.float64), compute_uv=False)
    return np.asarray(values[..., -1], dtype=np.float64)


def lost_directions(J: ArrayLike, tolerance: float = 1e-9) -> Array:
    """Unit six-vectors (v, omega) outside the range of one Jacobian, as columns, shape (6, k)."""
    U, S, _ = np.linalg.svd(np.asarray(J, dtype=np.float64))
    rank = int((tolerance * max(S[0], 1e-300) < S).sum())
    return U[:, rank:]
