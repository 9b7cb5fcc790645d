"""Errors of the instants at which a log has sampled the motors of a robot.

A motor that moves at rate w and is read d later than its stamp says is off by w d. Errors of motors
whose rates differ are therefore alike as times. They are found where a log departs from a cubic
over its neighbours, motor by motor, and applied to any smooth motion: what such a log makes of a
robot that repeats perfectly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from armside.arrays import Array

from ..measured.motion import Stream

HALF = 10
"""Samples on either side that the cubic spans."""
SLOWEST = 0.02
"""[rad/s] Rate below which a motor tells nothing of time."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TimingErrors:
    """Errors of the sampling instants of each motor, taken from logs."""

    errors: tuple[Array, ...]
    """Of each log (N, n) [s], in the order of its samples."""
    period: float
    """[s], median step of the stamps."""

    @property
    def deviation(self) -> Array:
        """(n,) [s], standard deviation of each motor."""
        return np.concatenate(self.errors).std(axis=0)

    @property
    def correlation(self) -> Array:
        """(n, n), between motors; 1 if all were read at one instant."""
        return np.asarray(np.corrcoef(np.concatenate(self.errors).T))

    def logged(self, motion: Stream, rng: np.random.Generator) -> Array:
        """Samples (N, n) [rad] that such a log holds of a motion, errors from a random place."""
        time = np.arange(motion.time[0], motion.time[-1], self.period)
        own = self.errors[rng.integers(len(self.errors))]
        rows = (np.arange(len(time)) + rng.integers(len(own))) % len(own)
        spline = CubicSpline(motion.time, motion.values)
        at = np.clip(time[:, None] + own[rows], motion.time[0], motion.time[-1])
        return np.column_stack([spline(at[:, j])[:, j] for j in range(at.shape[1])])


def timing_errors(logs: Sequence[Stream]) -> TimingErrors:
    """Timing errors of the samples of logs in motion.

    Raises ValueError for logs in which some motor never moves with the others.
    """
    found = tuple(_of(log) for log in logs)
    if not all(len(errors) for errors in found):
        raise ValueError("timing errors need logs in which all motors move at the same time")
    steps = np.concatenate([np.diff(log.time) for log in logs])
    return TimingErrors(errors=found, period=float(np.median(steps)))


def _of(log: Stream) -> Array:
    departure, rate = _local_cubic(log)
    moving = (np.abs(rate) > SLOWEST).all(axis=1)
    return departure[moving] / rate[moving]


def _local_cubic(log: Stream) -> tuple[Array, Array]:
    """Departure (N', n) [rad] of each sample from the cubic over its window, and rate [rad/s]."""
    centres = np.arange(HALF, len(log.time) - HALF)
    rows = centres[:, None] + np.arange(-HALF, HALF + 1)
    t = log.time[rows] - log.time[centres][:, None]
    unit = np.abs(t).max()
    powers = np.linalg.pinv((t / unit)[:, :, None] ** np.arange(4))
    fit = powers[:, :2] @ log.values[rows]
    return log.values[centres] - fit[:, 0], fit[:, 1] / unit
