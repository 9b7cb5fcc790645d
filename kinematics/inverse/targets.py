"""Checks of the poses that inverse kinematics is asked for."""

from typing import NoReturn

import numpy as np

from armside.arrays import Array

from ..rigid import ORTHOGONAL


def check_rigid(T: Array) -> None:
    """Refuse poses (..., 4, 4) that are not rigid motions."""
    R = T[..., :3, :3]
    if not (
        np.isfinite(T).all()
        and np.allclose(np.swapaxes(R, -1, -2) @ R, np.eye(3), rtol=0, atol=ORTHOGONAL)
        and (np.linalg.det(R) > 0).all()
        and (T[..., 3, :] == [0, 0, 0, 1]).all()
    ):
        refuse_motion(T)


def refuse_motion(T: Array) -> NoReturn:
    """Raise what is wrong with poses that are not rigid motions."""
    if not np.isfinite(T).all():
        raise ValueError("T must be finite; it contains NaN or infinity")
    raise ValueError("T must be rigid motions: a rotation, a position and a row 0 0 0 1")
