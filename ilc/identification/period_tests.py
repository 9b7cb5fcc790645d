"""Tests of periodic records: variances of complex spectra against each other, lines together."""

import numpy as np

from armside.arrays import Array

_ROUNDING = 1e-12  # relative to the greatest line of an output: below it nothing is measured


def excess(above: Array, noise: Array, signal: Array, freedom: tuple[int, int]) -> float:
    """Mean of F-distributed ratios over its expectation, in standard deviations of that mean.

    Args:
        above, noise: variances (lines, outputs, inputs), the ratio of which is tested. Outputs
            that are known exactly, as simulated ones, have rounding for noise, and those whose
            lines are rounding alone are left out.
        signal: amplitudes (lines, outputs, inputs) that rounding is relative to.
        freedom: of numerator and denominator. 0 where the latter is too small for a variance.
    """
    d1, d2 = freedom
    rounding = np.square(_ROUNDING * signal.max(axis=(0, 2), keepdims=True))
    there = np.maximum(above, noise) > rounding
    if d2 <= 4 or not there.any():
        return 0.0
    ratio = (above / np.maximum(noise, np.maximum(rounding, np.finfo(float).tiny)))[there]
    expected, count = d2 / (d2 - 2.0), there.any(axis=1).sum()
    variance = 2.0 * d2**2 * (d1 + d2 - 2.0) / (d1 * (d2 - 2.0) ** 2 * (d2 - 4.0))
    return float((np.mean(ratio) - expected) / np.sqrt(variance / count))


def scatter(Y: np.ndarray) -> float:
    """Excess of the first period over the others, (lines, outputs, experiments, periods)."""
    n, periods = Y.shape[2:]
    if periods < 3:
        return 0.0
    rest = Y[..., 1:]
    noise = rest.var(axis=3, ddof=1).mean(axis=2, keepdims=True) * (1.0 + 1.0 / (periods - 1))
    first = np.square(np.abs(Y[..., 0] - rest.mean(axis=3)))
    return excess(first, noise, np.abs(Y).max(axis=3), (2, 2 * n * (periods - 2)))
