"""Inverse velocity and acceleration of the tool, and statics. Thesis (2.11)-(2.14), (3.58)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..compiled import CompiledRobot

RANK = 1e-10
"""Singular values below this fraction of the greatest count as zero."""


class InconsistentMotionError(ValueError):
    """A motion of the tool outside the range of the Jacobian, against (2.12)."""


@dataclass(frozen=True)
class Rates:
    """Joint rates or accelerations, shape (n,), for a motion of the tool; rank of the Jacobian."""

    value: Array
    rank: int


def inverse_velocity(J: ArrayLike, X_dot: ArrayLike, b: ArrayLike | None = None) -> Rates:
    """Rates with J q_dot = X_dot: (2.11) if J is square and regular, else (2.13).

    J: shape (m, n).
    X_dot: shape (m,), desired (v, omega).
    b: shape (n,), added through the null space, (I - J^+ J) b; zero by default.

    Raises InconsistentMotionError: rank (J, X_dot) > rank J, the test (2.12); says which part of
    X_dot cannot be made.
    """
    J, X_dot = np.asarray(J, dtype=np.float64), np.asarray(X_dot, dtype=np.float64)
    if J.ndim != 2 or X_dot.shape != J.shape[:1]:
        raise ValueError(f"J must be (m, n) and X_dot (m,), got {J.shape} and {X_dot.shape}")
    b = np.zeros(J.shape[1]) if b is None else np.asarray(b, dtype=np.float64)
    if b.shape != J.shape[1:]:
        raise ValueError(f"b must have shape {J.shape[1:]}, got {b.shape}")
    if not (np.isfinite(J).all() and np.isfinite(X_dot).all() and np.isfinite(b).all()):
        raise ValueError("J, X_dot and b must be finite")
    U, S, Vt = np.linalg.svd(J)
    rank = int((RANK * S[0] < S).sum()) if S[0] > 0 else 0
    impossible = U[:, rank:] @ (U[:, rank:].T @ X_dot)
    if np.linalg.norm(impossible) > 1e-8 * np.linalg.norm(X_dot):
        raise InconsistentMotionError(
            f"the Jacobian has rank {rank} and cannot make the part "
            f"{np.round(impossible, 9).tolist()} of (v, omega)"
        )
    particular = Vt[:rank].T @ ((U[:, :rank].T @ X_dot) / S[:rank])
    null = Vt[rank:].T
    return Rates(particular + null @ (null.T @ b), rank)


def inverse_acceleration(
    functions: CompiledRobot,
    phi: ArrayLike,
    phi_dot: ArrayLike,
    X_ddot: ArrayLike,
    b: ArrayLike | None = None,
) -> Rates:
    """Motor accelerations with J phi_ddot + J' phi_dot = X_ddot. Thesis (2.14), (3.58).

    Raises InconsistentMotionError: the configuration is singular for this motion.
    """
    phi_dot = np.asarray(phi_dot, dtype=np.float64)
    drift = functions.acceleration(phi, phi_dot, np.zeros_like(phi_dot))
    return inverse_velocity(functions.jacobian(phi), np.asarray(X_ddot) - drift, b)


def joint_torques(J: ArrayLike, wrench: ArrayLike) -> Array:
    """tau = J^T F for Jacobians (..., 6, n) and wrenches (..., 6) = (force, moment).

    With J of motor rates these are motor torques on the arm side of the gear. Thesis (3.56).
    """
    J, wrench = np.asarray(J, dtype=np.float64), np.asarray(wrench, dtype=np.float64)
    return (np.swapaxes(J, -1, -2) @ wrench[..., None])[..., 0]
