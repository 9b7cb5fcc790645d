"""Confidence interval of a mean of few independent trials."""

import numpy as np

from armside.arrays import Array


def mean_interval(values: Array, confidence: float = 0.95) -> tuple[float, float]:
    """Interval by Student's t of the mean of values (n,); infinite for one value."""
    from scipy.special import stdtrit

    n, mean = len(values), float(np.mean(values))
    if n < 2:
        return -np.inf, np.inf
    half = stdtrit(n - 1, 0.5 + 0.5 * confidence) * np.std(values, ddof=1) / np.sqrt(n)
    return mean - float(half), mean + float(half)
