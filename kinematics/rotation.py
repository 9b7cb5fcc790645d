"""Rotation matrices and four ways to write them, numeric. Thesis 3.2.3; quaternions w first.

Every representation but the quaternion has singularities; `*_singular` detects them, and there
the functions from a matrix return a defined member of the solutions:

    axis/angle       angle 0: any axis, z is returned; angle pi: the axis has two signs, the one
                     whose first nonzero component is positive is returned
    Euler ZYZ        theta 0 or pi: only phi +- psi is determined, psi = 0 is returned
    roll-pitch-yaw   pitch +-pi/2: only roll +- yaw is determined, yaw (about x) = 0 is returned
    quaternion       none; q and -q are the same rotation, the one with w >= 0 is returned

All functions take leading batch axes.
"""

import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from armside.arrays import Array

SINGULAR = 1e-7
"""Sine of the angle below which a representation counts as singular."""
HALF_TURN = 1e-12
"""[rad] An angle this near to pi is a half turn, whose axis has either sign."""


def _rotation(R: ArrayLike) -> Rotation:
    R = np.asarray(R, dtype=np.float64)
    if R.shape[-2:] != (3, 3):
        raise ValueError(f"R must have shape (..., 3, 3), got {R.shape}")
    orthogonal = np.allclose(np.swapaxes(R, -1, -2) @ R, np.eye(3), rtol=0, atol=1e-6)
    if not orthogonal or (np.linalg.det(R) < 0).any():
        raise ValueError("R must be a rotation: orthogonal, with determinant +1, and finite")
    return Rotation.from_matrix(R)


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """R_{k,theta}, from an axis of any length and an angle [rad]. Thesis (3.9)."""
    axis, angle = np.asarray(axis, dtype=np.float64), np.asarray(angle, dtype=np.float64)
    length = np.linalg.norm(axis, axis=-1, keepdims=True)
    if not (np.isfinite(axis).all() and (length > 0).all()):
        raise ValueError(f"an axis must be finite and not zero, got {axis}")
    return Rotation.from_rotvec(axis / length * angle[..., None]).as_matrix()


def to_axis_angle(R: ArrayLike) -> tuple[Array, Array]:
    """Unit axis, shape (..., 3), and angle in [0, pi]."""
    vector = _rotation(R).as_rotvec()
    angle = np.linalg.norm(vector, axis=-1)
    unit = vector / np.where(angle == 0, 1.0, angle)[..., None]
    axis = np.where(angle[..., None] > 0, unit, [0.0, 0.0, 1.0])
    nonzero = np.argmax(np.abs(axis) > SINGULAR, axis=-1)[..., None]
    first = np.take_along_axis(axis, nonzero, axis=-1)
    opposite = (np.pi - angle < HALF_TURN)[..., None] & (first < 0)
    return np.where(opposite, -axis, axis), angle


def axis_angle_singular(R: ArrayLike) -> NDArray[np.bool_]:
    """True at angles 0 and pi, shape (...)."""
    return np.sin(_rotation(R).magnitude()) < SINGULAR


def from_euler_zyz(angles: ArrayLike) -> Array:
    """R_z(phi) R_y(theta) R_z(psi), angles (..., 3) = (phi, theta, psi). Thesis (3.10)."""
    return Rotation.from_euler("ZYZ", np.asarray(angles, dtype=np.float64)).as_matrix()


def to_euler_zyz(R: ArrayLike) -> Array:
    """(phi, theta, psi) with theta in [0, pi]."""
    return _angles("ZYZ", R)


def euler_zyz_singular(R: ArrayLike) -> NDArray[np.bool_]:
    """True at theta 0 and pi, shape (...)."""
    _rotation(R)
    return np.hypot(np.asarray(R)[..., 0, 2], np.asarray(R)[..., 1, 2]) < SINGULAR


def from_roll_pitch_yaw(angles: ArrayLike) -> Array:
    """R_z(roll) R_y(pitch) R_x(yaw), angles (..., 3) = (roll, pitch, yaw). Thesis (3.11)."""
    return Rotation.from_euler("ZYX", np.asarray(angles, dtype=np.float64)).as_matrix()


def to_roll_pitch_yaw(R: ArrayLike) -> Array:
    """(roll, pitch, yaw) with pitch in [-pi/2, pi/2]."""
    return _angles("ZYX", R)


def roll_pitch_yaw_singular(R: ArrayLike) -> NDArray[np.bool_]:
    """True at pitch +-pi/2, shape (...)."""
    _rotation(R)
    return np.hypot(np.asarray(R)[..., 0, 0], np.asarray(R)[..., 1, 0]) < SINGULAR


def _angles(sequence: str, R: ArrayLike) -> Array:
    with warnings.catch_warnings():  # scipy warns where it sets the third angle to zero
        warnings.simplefilter("ignore", UserWarning)
        return _rotation(R).as_euler(sequence)


def from_quaternion(q: ArrayLike) -> Array:
    """R of a quaternion of any length, shape (..., 4), w first. Thesis (3.14)."""
    q = np.asarray(q, dtype=np.float64)
    if q.shape[-1:] != (4,) or not (np.linalg.norm(q, axis=-1) > 0).all():
        raise ValueError(f"a quaternion has 4 finite numbers, not all zero, got {q}")
    return Rotation.from_quat(q, scalar_first=True).as_matrix()


def to_quaternion(R: ArrayLike) -> Array:
    """Unit quaternion with w >= 0, shape (..., 4)."""
    return _rotation(R).as_quat(canonical=True, scalar_first=True)


def quaternion_product(p: ArrayLike, q: ArrayLike) -> Array:
    """p q: first the rotation q, then p."""
    p, q = np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64)
    w = p[..., 0] * q[..., 0] - (p[..., 1:] * q[..., 1:]).sum(-1)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w[..., None], v], axis=-1)


def slerp(q_start: ArrayLike, q_end: ArrayLike, s: ArrayLike) -> Array:
    """Unit quaternions (N, 4), w >= 0, of the shortest rotation at constant angular velocity.

    Args:
        s: shape (N,), each in [0, 1], from the start to the end.
    """
    ends = Rotation.from_quat(np.array([q_start, q_end], dtype=np.float64), scalar_first=True)
    return Slerp([0.0, 1.0], ends)(np.atleast_1d(s)).as_quat(canonical=True, scalar_first=True)
