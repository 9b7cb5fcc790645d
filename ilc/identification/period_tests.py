"""Tests of periodic records: variances of complex spectra against each other, lines together."""

import numpy as np

from armside.arrays import Array


def excess(ratio: Array, freedom: tuple[int, int], count: int) -> float:
    """Mean of F-distributed ratios above its expectation, in standard deviations of that mean.

    freedom: of numerator and denominator; count: of ratios that are independent. 0 where the
    denominator has too few degrees of freedom for a variance.
    """
    d1, d2 = freedom
    if d2 <= 4:
        return 0.0
    expected = d2 / (d2 - 2.0)
    variance = 2.0 * d2**2 * (d1 + d2 - 2.0) / (d1 * (d2 - 2.0) ** 2 * (d2 - 4.0))
    return float((np.mean(ratio) - expected) / np.sqrt(variance / count))


def scatter(Y: np.ndarray) -> float:
    """Excess of the first period over the others, (lines, outputs, experiments, periods)."""
    n_lines, _, n, periods = Y.shape
    if periods < 3:
        return 0.0
    rest = Y[..., 1:]
    noise = rest.var(axis=3, ddof=1).mean(axis=2, keepdims=True) * (1.0 + 1.0 / (periods - 1))
    ratio = np.square(np.abs(Y[..., 0] - rest.mean(axis=3))) / noise
    return excess(ratio, (2, 2 * n * (periods - 2)), n_lines * n)
