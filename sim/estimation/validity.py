"""Validity of an estimate: innovations and what the IMU adds, second by second."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from .estimator import ToolEstimate

WINDOW = 1.0
"""[s], of the record that is judged as one: a hundred readings."""
SHORT = 4.0
"""Length of a run [s] up to which it is short: a window is half of it, and what the model lacks has
no time to grow. ESTIMATE: contours of 8 to 40 mm take 2 to 3 s, long paths from 5 s on."""


@dataclass(frozen=True)
class Limits:
    """Beyond which an estimate is not valid."""

    innovation: float
    """RMS of whitened innovations in a window."""
    shift: float
    """Distance [m] by which an IMU moves the path that motors and springs explain."""


OF_LONG = Limits(5.0, 0.5e-3)
"""Sound runs have 1 to 3, the largest at corners. Where a gear without load moves within its lost
motion as no model foresees, there are more, and learned from they grow. ESTIMATE"""
OF_SHORT = Limits(30.0, 2e-3)
"""Here the smoother mends that: sound runs have up to 19 and 1.1 mm. A knock of 5 m/s^2 for 40 ms
has 52, one of 50 m/s^2 4 mm. Seeds from 100 on. ESTIMATE"""
FADE = 0.1
"""[s], over which validity is lost before such a window and gained after it."""


@dataclass(frozen=True, eq=False)
class Validity:
    """Validity of one estimate."""

    weight: Array
    """(N,) in [0, 1]."""
    text: str
    """Where it is not valid; empty where it is everywhere."""


def validity(estimate: ToolEstimate, time: Array) -> Validity:
    """Of an estimate at the instants (N,) of the motor log."""
    limits = OF_SHORT if time[-1] < SHORT else OF_LONG
    window = (time / WINDOW).astype(int)
    good = np.ones(window[-1] + 1, dtype=bool)
    for at in range(len(good)):
        innovation = estimate.innovation[(estimate.instants / WINDOW).astype(int) == at]
        known = np.isfinite(innovation).all(axis=1)
        if known.any():
            good[at] = np.sqrt(np.square(innovation[known]).mean(axis=0)).max() < limits.innovation
        shift = np.linalg.norm(estimate.shift[window == at], axis=1)
        good[at] &= bool((shift < limits.shift).all())
    weight = _faded(good[window].astype(float), round(FADE / float(time[1] - time[0])))
    if good.all():
        return Validity(weight, "")
    places = ", ".join(f"{WINDOW * at:g}" for at in np.flatnonzero(~good))
    seconds = "second that begins" if (~good).sum() == 1 else "seconds that begin"
    text = f"the estimate is not valid, and nothing learned, in the {seconds} at {places} s"
    return Validity(weight, text)


def _faded(weight: Array, samples: int) -> Array:
    """The smallest weight nearby, smoothed."""

    def nearby(values: Array) -> Array:
        padded = np.pad(values, samples, mode="edge")
        return np.lib.stride_tricks.sliding_window_view(padded, 2 * samples + 1)

    return nearby(nearby(weight).min(axis=1)).mean(axis=1)
