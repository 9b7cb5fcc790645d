"""A signal of one sample rate at another, with its band limited.

At the same rate samples are taken as they are. At a higher one a cubic spline goes through every
sample. At a lower one the signal first passes a zero-phase Butterworth low-pass (order 2, forwards
and backwards, gain 1/2 at 0.4 of the new rate), so that nothing above half the new rate folds back.
The last value is held to the first new sample at or beyond the old end.
"""

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import Edge, ZeroPhaseButterworth

BAND = 0.4
"""Cutoff of the low-pass over the new rate."""
RATES = (1.0, 20_000.0)
"""[Hz], lowest and highest."""
MOST_SAMPLES = 5_000_000


def resampled(values: Array, sample_time: float, rate: float) -> Array:
    """Values (N, n) of a sample time [s] at a rate [Hz]: shape (M, n).

    Raises ValueError for a rate out of range, or one that is too low for so short a record.
    """
    from scipy.interpolate import CubicSpline

    low, high = RATES
    if not low <= rate <= high:
        raise ValueError(f"rate must be {low:g} to {high:g} Hz, got {rate:g}")
    if np.isclose(rate * sample_time, 1.0, rtol=1e-9, atol=0.0):
        return values
    end = (len(values) - 1) * sample_time
    count = int(np.ceil(end * rate - 1e-6)) + 1
    if count > MOST_SAMPLES:
        raise ValueError(f"at most {MOST_SAMPLES} samples are written, {rate:g} Hz make {count}")
    banded = values if rate * sample_time > 1.0 else _low_pass(values, sample_time, BAND * rate)
    time = np.arange(len(values)) * sample_time
    return CubicSpline(time, banded)(np.minimum(np.arange(count) / rate, end))


def _low_pass(values: Array, sample_time: float, cutoff: float) -> Array:
    low_pass = ZeroPhaseButterworth(cutoff, sample_time, edge=Edge.ODD)
    return low_pass(values)
