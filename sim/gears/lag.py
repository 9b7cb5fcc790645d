"""Offset of two clocks over all lags, from one quantity that both instruments saw."""

import numpy as np

from armside.arrays import Array

STEP = 0.01
"""[s] Of the search."""
CORRELATED = 0.3
"""Correlation below which the two did not see the same motion."""
OVERLAP = 0.5
"""Of the shorter record, that both must have seen."""


def coarse_lag(name: str, own: tuple[Array, Array], robot: tuple[Array, Array]) -> float:
    """Own clock minus the robot's clock at the same instant [s].

    Args:
        name: of the instrument, for the error.
        own: time (K,) [s] and speed (K,). robot: the same by the robot, at its clock.

    Raises:
        ValueError: no lag makes the two alike.
    """
    likeness, n = _likeness(own, robot)
    best = int(np.argmax(likeness))
    if not likeness[best] > CORRELATED:
        text = f"{name} and encoders did not see the same motion at any offset of their clocks"
        raise ValueError(f"{text} (correlation {likeness[best]:.2f})")
    return float((best - n + 1) * STEP + own[0][0] - robot[0][0])


def likeness_at_best_lag(own: tuple[Array, Array], robot: tuple[Array, Array]) -> float:
    """Largest correlation of the two over all lags, -1 to 1."""
    return float(_likeness(own, robot)[0].max())


def _likeness(own: tuple[Array, Array], robot: tuple[Array, Array]) -> tuple[Array, int]:
    """Correlation at each lag, and samples of the robot's signal on the even grid."""
    from scipy.signal import correlate

    a, b = (_even(*signal) for signal in (own, robot))
    product = correlate(a, b, "full", "fft")
    overlap = correlate(np.ones_like(a), np.ones_like(b), "full", "fft")
    energy = correlate(a**2, np.ones_like(b), "full", "fft")
    energy *= correlate(np.ones_like(a), b**2, "full", "fft")
    floor = np.finfo(float).eps * energy.max()
    likeness = product / np.sqrt(np.maximum(energy, max(floor, np.finfo(float).tiny)))
    likeness[overlap < OVERLAP * min(len(a), len(b))] = -1.0
    return likeness, len(b)


def _even(time: Array, values: Array) -> Array:
    from scipy.interpolate import CubicSpline

    grid = np.arange(time[0], time[-1], STEP)
    even = CubicSpline(time, values)(grid)
    return even - even.mean()
