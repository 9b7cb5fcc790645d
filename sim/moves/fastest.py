"""Time-optimal path parametrisation of one curve, rest to rest, with limits that vary along it.

A forward and a backward pass find the highest speed within the limits of speed and acceleration,
which are symmetric. A moving average over the jerk time then limits the jerk.
"""

import numpy as np

from armside.arrays import Array

from ..cut.timing import Timing
from .bounds import TINY, Bounds

CHECKS = 1000
"""Instants at which a timing is compared with its limits."""


def fastest(bounds: Bounds, jerk_time: float) -> Timing:
    """Fastest timing of w from 0 to 1, at rest at both ends.

    jerk_time: [s], in which the acceleration builds up, falls or changes sign.
    """
    x = bounds.speed**2
    x[[0, -1]] = 0.0
    x = _reached(x, bounds.along, bounds.bend)
    x = _reached(x[::-1], bounds.along[::-1], bounds.bend[::-1])[::-1]
    timing = averaged(x, jerk_time)
    # Where limits change within the jerk time, an average may pass them: by 0.6 % in our programs.
    factor = max(1.0, _excess(timing, bounds))
    state = timing.state * factor ** -np.arange(4.0)
    return Timing(timing.start * factor, state, timing.duration * factor)


def _reached(x: Array, along: Array, bend: Array) -> Array:
    """w'^2 where it can rise no faster than acceleration allows, at both ends of each interval."""
    x, step = x.copy(), 1.0 / (len(x) - 1)
    along = np.maximum(np.maximum(along[:-1], along[1:]), TINY)
    bend = np.maximum(bend[:-1], bend[1:])
    for i in range(len(x) - 1):
        steepest = (np.maximum(1.0 - bend[i] * x[i], 0.0) / along[i]).min()
        x[i + 1] = min(x[i + 1], x[i] + 2.0 * step * steepest)
    return x


def averaged(x: Array, window: float) -> Timing:
    """Motion of w'^2 = x on an even grid, linear between, averaged over `window` [s] of time.

    Its acceleration is constant in each interval, its average linear: phases of constant jerk.
    """
    v, step = np.sqrt(x), 1.0 / (len(x) - 1)
    knots = np.concatenate([[0.0], np.cumsum(2.0 * step / (v[:-1] + v[1:]))])
    acceleration = np.diff(x) / (2.0 * step)
    start = np.unique(np.concatenate([knots, knots + window]))
    length = np.diff(start)
    middle = start[:-1] + 0.5 * length
    entering, leaving = (_held(acceleration, knots, t) for t in (middle, middle - window))
    state = np.zeros((len(length), 4))
    state[:, 3] = (entering - leaving) / window
    for k, h in enumerate(length[:-1]):
        s, v, a, j = state[k]
        moved = s + h * (v + h * (a / 2 + h * j / 6))
        state[k + 1, :3] = moved, v + h * (a + h * j / 2), a + h * j
    return Timing(start[:-1], state, float(start[-1]))


def _held(values: Array, knots: Array, time: Array) -> Array:
    """Zero-order hold between knots, zero outside."""
    k = np.searchsorted(knots, time, side="right") - 1
    inside = (k >= 0) & (k < len(values))
    return np.where(inside, values[np.clip(k, 0, len(values) - 1)], 0.0)


def _excess(timing: Timing, bounds: Bounds) -> float:
    """Factor on the duration with which a timing keeps all limits."""
    w, v, a = timing.at(np.linspace(0.0, timing.duration, CHECKS))
    grid = np.linspace(0.0, 1.0, len(bounds.speed))
    along, bend = (
        np.stack([np.interp(w, grid, column) for column in table.T], axis=1)
        for table in (bounds.along, bounds.bend)
    )
    used = bend * (v**2)[:, np.newaxis] + along * np.abs(a)[:, np.newaxis]
    return float(max((v / np.interp(w, grid, bounds.speed)).max(), np.sqrt(used.max())))
