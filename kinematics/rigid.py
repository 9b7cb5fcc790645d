"""Rigid motions as homogeneous transforms, numeric. Thesis (2.2), (3.15)-(3.21).

Frames read as a sum: p_a = T_a_b @ p_b. Every function takes leading batch axes.
"""

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .arguments import real_array

ORTHOGONAL = 1e-6
"""Greatest element of R^T R - 1 of a matrix that counts as a rotation."""


def transform(R: ArrayLike, d: ArrayLike) -> Array:
    """T = [R d; 0 1], shape (..., 4, 4). Thesis (3.17)."""
    R, d = real_array("R", R), real_array("d", d)
    if R.shape[-2:] != (3, 3) or d.shape[-1:] != (3,):
        raise ValueError(f"R must be (..., 3, 3) and d (..., 3), got {R.shape} and {d.shape}")
    T = np.zeros((*np.broadcast_shapes(R.shape[:-2], d.shape[:-1]), 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, d, 1.0
    return T


def inverse(T_a_b: ArrayLike) -> Array:
    """T_b_a = [R^T, -R^T d; 0 1]. Thesis (3.20)."""
    T = real_array("T_a_b", T_a_b, 4, 4)
    R_b_a = np.swapaxes(T[..., :3, :3], -1, -2)
    if not np.allclose(R_b_a @ T[..., :3, :3], np.eye(3), rtol=0, atol=ORTHOGONAL):
        raise ValueError("T_a_b must be a rigid motion: its rotation is not orthogonal")
    return transform(R_b_a, -(R_b_a @ T[..., :3, 3:])[..., 0])


def transform_points(T_a_b: ArrayLike, p_b: ArrayLike) -> Array:
    """p_a = R p_b + d for points p_b of shape (..., 3). Thesis (3.15)."""
    T, p = real_array("T_a_b", T_a_b, 4, 4), real_array("p_b", p_b, 3)
    return (T[..., :3, :3] @ p[..., None])[..., 0] + T[..., :3, 3]
