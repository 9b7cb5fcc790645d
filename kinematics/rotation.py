"""Rotation matrices and four ways to write them, numeric. Thesis 3.2.3; quaternions w first.

Every representation but the quaternion has singularities, and `*_singular` detects their
neighbourhood, SINGULAR wide, where two of the angles are ill determined one by one. The rotation
itself is returned to rounding everywhere; at the singularity a defined member of its solutions is:

    axis/angle       angle 0: any axis, z is returned; angle pi: the axis has two signs, the one
                     whose first nonzero component is positive is returned
    Euler ZYZ        theta 0 or pi: only phi +- psi is determined, psi = 0 is returned
    roll-pitch-yaw   pitch +-pi/2: only roll +- yaw is determined, yaw (about x) = 0 is returned
    quaternion       none; q and -q are the same rotation, the one with w >= 0 is returned

All functions take leading batch axes. SciPy is imported where it is used: its import takes longer
than a command line takes to be refused.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, finite_array, real_array

from .rigid import ORTHOGONAL

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

SINGULAR = 1e-7
"""Sine of the angle below which a representation counts as singular."""
_ROUNDING = 2e-15
"""Sine of the angle that rounding of a matrix can make: below it the third angle is 0."""
HALF_TURN = 1e-15
"""[rad] An angle this near to pi is a half turn, whose axis has either sign."""


def _scipy() -> "type[Rotation]":
    from scipy.spatial.transform import Rotation

    return Rotation


def _rotation(R: ArrayLike) -> "Rotation":
    R = real_array("R", R, 3, 3)
    orthogonal = np.allclose(np.swapaxes(R, -1, -2) @ R, np.eye(3), rtol=0, atol=ORTHOGONAL)
    if not orthogonal or (np.linalg.det(R) < 0).any():
        raise ValueError("R must be a rotation: orthogonal, with determinant +1, and finite")
    return _scipy().from_matrix(R)


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """R_{k,theta}, from an axis of any length and an angle [rad]. Thesis (3.9)."""
    scaled = _scaled("axis", axis, 3)
    unit = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
    angle = finite_array("angle", angle)
    angle = np.where(np.abs(angle) > 2 * np.pi, np.remainder(angle, 2 * np.pi), angle)
    return _scipy().from_rotvec(unit * angle[..., None]).as_matrix()


def _scaled(name: str, vector: ArrayLike, size: int) -> Array:
    """Vectors (..., size) that are not zero, scaled so that no square overflows or vanishes.

    The scale is a power of two, which changes no digit.
    """
    vector = finite_array(name, vector, size)
    greatest = np.abs(vector).max(axis=-1, keepdims=True)
    if not (greatest > 0).all():
        raise ValueError(f"{name} must not be zero, got {vector}")
    return np.ldexp(vector, -np.frexp(greatest)[1])


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
    return _scipy().from_euler("ZYZ", finite_array("angles", angles, 3)).as_matrix()


def to_euler_zyz(R: ArrayLike) -> Array:
    """(phi, theta, psi) with theta in [0, pi]."""
    R = np.asarray(_rotation(R).as_matrix(), dtype=np.float64)
    sine = np.hypot(R[..., 0, 2], R[..., 1, 2])
    phi, c, s = _first_angle(R, R[..., 1, 2], R[..., 0, 2], sine)
    psi = np.arctan2(c * R[..., 1, 0] - s * R[..., 0, 0], c * R[..., 1, 1] - s * R[..., 0, 1])
    return np.stack([phi, np.arctan2(sine, R[..., 2, 2]), _third_angle(psi, sine)], axis=-1)


def _first_angle(R: Array, y: Array, x: Array, sine: Array) -> tuple[Array, Array, Array]:
    """Angle about z, with its cosine and sine, from (y, x); by R itself where the third is 0."""
    aligned = np.arctan2(-R[..., 0, 1], R[..., 1, 1])
    angle = np.where(sine > _ROUNDING, np.arctan2(y, x), aligned)
    return angle, np.cos(angle), np.sin(angle)


def _third_angle(angle: Array, sine: Array) -> Array:
    """The third angle, from the rest of the rotation; 0 at the singularity."""
    return np.where(sine > _ROUNDING, angle, 0.0)


def euler_zyz_singular(R: ArrayLike) -> NDArray[np.bool_]:
    """True at theta 0 and pi, shape (...)."""
    _rotation(R)
    return np.hypot(np.asarray(R)[..., 0, 2], np.asarray(R)[..., 1, 2]) < SINGULAR


def from_roll_pitch_yaw(angles: ArrayLike) -> Array:
    """R_z(roll) R_y(pitch) R_x(yaw), angles (..., 3) = (roll, pitch, yaw). Thesis (3.11)."""
    return _scipy().from_euler("ZYX", finite_array("angles", angles, 3)).as_matrix()


def to_roll_pitch_yaw(R: ArrayLike) -> Array:
    """(roll, pitch, yaw) with pitch in [-pi/2, pi/2]."""
    R = np.asarray(_rotation(R).as_matrix(), dtype=np.float64)
    cosine = np.hypot(R[..., 0, 0], R[..., 1, 0])
    roll, c, s = _first_angle(R, R[..., 1, 0], R[..., 0, 0], cosine)
    yaw = np.arctan2(s * R[..., 0, 2] - c * R[..., 1, 2], c * R[..., 1, 1] - s * R[..., 0, 1])
    pitch = np.arctan2(-R[..., 2, 0], cosine)
    return np.stack([roll, pitch, _third_angle(yaw, cosine)], axis=-1)


def roll_pitch_yaw_singular(R: ArrayLike) -> NDArray[np.bool_]:
    """True at pitch +-pi/2, shape (...)."""
    _rotation(R)
    return np.hypot(np.asarray(R)[..., 0, 0], np.asarray(R)[..., 1, 0]) < SINGULAR


def from_quaternion(q: ArrayLike) -> Array:
    """R of a quaternion of any length, shape (..., 4), w first. Thesis (3.14)."""
    return _scipy().from_quat(_scaled("quaternion", q, 4), scalar_first=True).as_matrix()


def to_quaternion(R: ArrayLike) -> Array:
    """Unit quaternion with w >= 0, shape (..., 4)."""
    return _rotation(R).as_quat(canonical=True, scalar_first=True)


def quaternion_product(p: ArrayLike, q: ArrayLike) -> Array:
    """p q: first the rotation q, then p."""
    p, q = real_array("p", p, 4), real_array("q", q, 4)
    w = p[..., 0] * q[..., 0] - (p[..., 1:] * q[..., 1:]).sum(-1)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w[..., None], v], axis=-1)


def slerp(q_start: ArrayLike, q_end: ArrayLike, s: ArrayLike) -> Array:
    """Unit quaternions (N, 4), w >= 0, of the shortest rotation at constant angular velocity.

    s: shape (N,), each in [0, 1], from the start to the end.
    """
    from scipy.spatial.transform import Slerp

    quaternions = _scaled("quaternion", np.array([q_start, q_end], dtype=np.float64), 4)
    ends = _scipy().from_quat(quaternions, scalar_first=True)
    return Slerp([0.0, 1.0], ends)(np.atleast_1d(s)).as_quat(canonical=True, scalar_first=True)
