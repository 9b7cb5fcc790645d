"""Unit quaternions (..., 4), w first, base to tool, as arrays."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def normalised(quaternion: ArrayLike) -> Array:
    """A quaternion (4,) of unit length.

    Raises:
        ValueError: not four finite numbers, or all zero.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    if q.shape != (4,) or not np.all(np.isfinite(q)) or np.linalg.norm(q) < 1e-9:
        raise ValueError(f"quaternion must be four finite numbers, not all zero, got {quaternion}")
    return q / np.linalg.norm(q)


def rotation(quaternion: Array) -> Array:
    """Rotation matrices (..., 3, 3). Thesis 3.2.3."""
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
