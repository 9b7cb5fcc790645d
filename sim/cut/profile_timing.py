"""Timing of a speed profile: phases of constant jerk."""

import numpy as np

from armside.arrays import Array

from .timing import Timing


def profile_timing(acceleration: Array, steps: Array, jerk: float, ramp: float) -> Timing:
    """Ramps of `jerk` for `ramp` [s] at both ends, and between them `acceleration` for `steps` [s].

    Each change of acceleration is spread over half of the shorter step before and after it.
    """
    half = np.concatenate([[0.0], 0.5 * np.minimum(steps[:-1], steps[1:]), [0.0]])
    knots = ramp + np.concatenate([[0.0], np.cumsum(steps)])
    change = np.diff(acceleration)
    held = np.column_stack([knots[:-1] + half[:-1], np.zeros(len(steps))])
    blends = np.column_stack([knots[1:-1] - half[1:-1], change / (2.0 * half[1:-1])])
    phases = np.empty((2 * len(steps) - 1, 2))
    phases[::2], phases[1::2] = held, blends
    start = np.concatenate([[0.0], phases[:, 0], knots[-1:]])
    j = np.concatenate([[jerk], phases[:, 1], [jerk]])
    h = np.diff(start, append=knots[-1] + ramp)
    a = _summed(h * j)
    v = _summed(h * (a + h * j / 2))
    s = _summed(h * (v + h * (a / 2 + h * j / 6)))
    return Timing(start, np.stack([s, v, a, j], axis=1), float(knots[-1] + ramp))


def _summed(change: Array) -> Array:
    """Values at the start of each phase, from their changes."""
    return np.concatenate([[0.0], np.cumsum(change)[:-1]])
