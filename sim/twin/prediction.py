"""Predicted tool error of a corrected first run, with an interval.

    expected^2 = b^2 (s^2 + (a h)^2)        interval = expected * (low, high)

s is the root mean square error of the individuals around the twin, h the residual of cuts that the
twin was not identified from. a, b, low and high were fitted to 36 cuts of the individuals 1002,
1003 and 1008, which are not the judged ones: there log(expected) and log(error) correlate by 0.87.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

_RESIDUAL, _SCALE = 0.15, 0.8
"""a and b."""
_LOW, _HIGH = 0.6, 1.75
"""Of 90 %."""


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Errors of the tool to expect of a first run [m]."""

    uncorrected: float
    """Without correction, by the twin."""
    inside: float
    """With correction, inside the twin."""
    expected: float
    low: float
    high: float
    """With correction, in the robot: expectation and interval of 90 %."""


def predicted(uncorrected: float, inside: float, around: Array, residual: float) -> Prediction:
    """Prediction from errors around the twin (n,) [m] and the residual of held-out cuts [m]."""
    expected = _SCALE * float(np.sqrt(np.mean(around**2) + (_RESIDUAL * residual) ** 2))
    return Prediction(
        uncorrected=uncorrected,
        inside=inside,
        expected=expected,
        low=_LOW * expected,
        high=_HIGH * expected,
    )
