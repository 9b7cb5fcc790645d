"""Divergence of a learning experiment: the one rule of all learning loops."""

import numpy as np

from armside.arrays import Array

DIVERGENCE_RATIO = 3.0
"""Size of an error over its size at k = 0, beyond which learning has diverged."""


def has_diverged(size: Array, first: Array, ratio: float = DIVERGENCE_RATIO) -> bool:
    """Errors that are not finite, or of which one exceeds `ratio` times its size at k = 0.

    Args:
        size: (n,) sizes of the columns of an error, such as their 2-norms; first: those at k = 0.
        ratio: infinity for no limit.
    """
    within = np.isfinite(size) if np.isinf(ratio) else size <= ratio * first
    return not bool(np.all(within & np.isfinite(size)))
