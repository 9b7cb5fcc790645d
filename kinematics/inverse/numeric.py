"""Inverse kinematics by damped Gauss-Newton steps, for any robot that `compile` takes."""

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..compiled import compile
from ..dh import Robot

_CONVERGED = 1e-12  # [m] and [rad]
_MAX_STEPS = 200


class NotConvergedError(ValueError):
    """No configuration found from a start; the target may be out of reach."""


def inverse_numeric(robot: Robot, T: ArrayLike, start: ArrayLike, tolerance: float = 1e-9) -> Array:
    """One configuration phi with pose T, found from a start configuration.

    Levenberg-Marquardt on the six-vector (position, rotation vector) from the current pose to T.

    Args:
        T: shape (4, 4).
        start: shape (n,) [rad].
        tolerance: largest remaining error that is accepted [m] and [rad].

    Raises:
        NotConvergedError: says what error remains.
    """
    T = np.asarray(T, dtype=np.float64)
    phi = np.array(start, dtype=np.float64)
    if T.shape != (4, 4) or phi.shape != (robot.n_joints,):
        given = f"got {T.shape} and {phi.shape}"
        raise ValueError(f"T must be (4, 4) and start ({robot.n_joints},), {given}")
    if not (np.isfinite(T).all() and np.isfinite(phi).all()):
        raise ValueError("T and start must be finite")
    functions = compile(robot)
    damping, error = 1e-3, pose_error(functions.pose(phi), T)
    for _ in range(_MAX_STEPS):
        if np.abs(error).max() < _CONVERGED:
            break
        J = functions.jacobian(phi)
        step = np.linalg.solve(J.T @ J + damping * np.eye(len(phi)), J.T @ error)
        trial = pose_error(functions.pose(phi + step), T)
        if trial @ trial < error @ error:
            phi, error, damping = phi + step, trial, max(damping / 10, 1e-15)
        elif damping > 1e6:
            break
        else:
            damping *= 4
    if not np.abs(error).max() <= tolerance:
        distance, angle = np.linalg.norm(error[:3]) * 1e3, np.degrees(np.linalg.norm(error[3:]))
        raise NotConvergedError(
            f"no configuration of {robot.name} found from this start: "
            f"{distance:.3f} mm and {angle:.3f} deg remain"
        )
    return phi


def pose_error(T_base_a: Array, T_base_b: Array) -> Array:
    """(translation, rotation vector) in base axes that takes frame a to frame b, shape (6,)."""
    from scipy.spatial.transform import Rotation

    rotation = Rotation.from_matrix(T_base_b[:3, :3] @ T_base_a[:3, :3].T).as_rotvec()
    return np.concatenate([T_base_b[:3, 3] - T_base_a[:3, 3], rotation])
