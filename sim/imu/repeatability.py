"""Repeatability of an IMU's constants over recordings of one robot."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from armside.arrays import Array

from ..gears.imu_alignment import ImuAlignment


@dataclass(frozen=True, kw_only=True, eq=False)
class Repeatability:
    """Largest differences between any two recordings."""

    gyro_scale: float
    accelerometer_scale: float
    """Of the singular values of M."""
    mounting: float
    """[rad], angle of the rotation between two mountings by the gyro."""
    lever: Array
    """(3,) [m]."""
    gravity: float
    """[rad], angle between two directions of gravity in base axes."""


def repeatability(alignments: Sequence[ImuAlignment]) -> Repeatability:
    """Differences between two alignments or more. Raises ValueError for fewer."""
    if len(alignments) < 2:
        raise ValueError(f"repeatability needs two recordings, got {len(alignments)}")
    pairs = list(combinations(alignments, 2))
    return Repeatability(
        gyro_scale=_spread([scale(one.M_gyro) for one in alignments]),
        accelerometer_scale=_spread([scale(one.M_accelerometer) for one in alignments]),
        mounting=max(_apart(a.R_imu_tool, b.R_imu_tool) for a, b in pairs),
        lever=np.ptp([one.lever for one in alignments], axis=0),
        gravity=max(_between(a.gravity, b.gravity) for a, b in pairs),
    )


def scale(M: Array) -> Array:
    """(3,), singular values of a sensor's matrix, the largest first."""
    return np.linalg.svd(M)[1]


def mounting(one: ImuAlignment) -> Array:
    """(3,) [rad], rotation vector of the axes of the tool in those of the housing."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(one.R_imu_tool).as_rotvec()


def _spread(values: Sequence[Array]) -> float:
    return float(np.ptp(values, axis=0).max())


def _apart(A: Array, B: Array) -> float:
    from scipy.spatial.transform import Rotation

    return float(Rotation.from_matrix(A @ B.T).magnitude())


def _between(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
