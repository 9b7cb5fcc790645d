"""Offset of two clocks over all lags, from one quantity that both instruments saw."""

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.interpolate import CubicSpline

from armside.arrays import Array

STEP = 0.01
"""[s] Of the search."""
CORRELATED = 0.3
"""Correlation below which the two did not see the same motion."""


def coarse_lag(name: str, own: tuple[Array, Array], robot: tuple[Array, Array]) -> float:
    """Own clock minus the robot's clock at the same instant [s].

    Args:
        name: of the instrument, for the error.
        own: time (K,) [s] and speed (K,). robot: the same by the robot, at its clock.

    Raises:
        ValueError: no lag makes the two alike.
    """
    a, b = (_even(*signal) for signal in (own, robot))
    size = next_fast_len(len(a) + len(b))
    product = irfft(rfft(a, size) * np.conj(rfft(b, size)), size)
    best = int(np.argmax(product))
    likeness = product[best] / max(np.linalg.norm(a) * np.linalg.norm(b), np.finfo(float).tiny)
    if not likeness > CORRELATED:
        text = f"{name} and encoders did not see the same motion at any offset of their clocks"
        raise ValueError(f"{text} (correlation {likeness:.2f})")
    lag = best - size if best > len(a) else best
    return float(lag * STEP + own[0][0] - robot[0][0])


def _even(time: Array, values: Array) -> Array:
    grid = np.arange(time[0], time[-1], STEP)
    even = CubicSpline(time, values)(grid)
    return even - even.mean()
