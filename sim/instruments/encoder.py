"""Motor encoder: quantisation of the motor angle, at n times the arm-side angle."""

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array


def resolution(counts: float, gear_ratio: ArrayLike) -> Array:
    """One count as an arm-side angle [rad]: 2 pi / (counts per motor revolution * gear ratio)."""
    ratio = np.abs(np.asarray(gear_ratio, dtype=np.float64))
    if not (counts > 0 and np.all(ratio > 0.0)):
        raise ValueError(
            f"counts per turn must be > 0 and gear ratios not 0, got {counts}, {gear_ratio}"
        )
    return 2.0 * np.pi / (counts * ratio)


def quantise(angle: ArrayLike, counts: float, gear_ratio: ArrayLike) -> Array:
    """Arm-side angles (..., n) [rad], rounded to whole encoder counts. Thesis 5.3.1."""
    q = resolution(counts, gear_ratio)
    return np.rint(np.asarray(angle, dtype=np.float64) / q) * q
