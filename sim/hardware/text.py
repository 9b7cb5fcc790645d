"""Numbers and poses as text of an MJCF, without loss."""

from collections.abc import Iterable

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

_ROUNDING = 15
"""Decimals; rounding of a right angle leaves 6e-17."""


def number(value: float) -> str:
    """Shortest text of a number that reads back as the same."""
    short = round(float(value), _ROUNDING) if abs(value) < 1.0 else float(value)
    return repr(int(short)) if short == int(short) and abs(short) < 1e15 else repr(short)


def row(values: ArrayLike | Iterable[float]) -> str:
    """Numbers with spaces between."""
    return " ".join(number(value) for value in np.atleast_1d(np.asarray(values)).ravel().tolist())


def pose(T: Array) -> str:
    """Attributes pos and quat of a transform (4, 4), none for the identity."""
    found = ""
    if np.abs(T[:3, 3]).max() > 1e-15:
        found += f' pos="{row(T[:3, 3])}"'
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(T[:3, :3]).ravel())
    if abs(abs(quaternion[0]) - 1.0) > 1e-15:
        found += f' quat="{row(quaternion)}"'
    return found
