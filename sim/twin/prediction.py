"""Predicted tool error of a corrected first run, with an interval.

    expected^2 = e^2 + b^2 (s^2 - e^2) + (a h)^2        interval = expected * (low, high)

e is the error inside the twin, s the root mean square error of the individuals around it, h the
residual of cuts that the twin was not identified from. a, b, low and high were fitted to fourteen
cuts each of eight individuals among `DEVELOPMENT` of `armside verify first-cut`, which are not the
judged ones: 1001, 1003, 1004, 1006, 1007, 1009, 1010 and 1012. Errors of one individual resemble
each other, so low and high are such that 90 % of each are inside those of the seven others.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

_RESIDUAL, _SPREAD = 0.3, 0.4
"""a and b. Individuals differ from the twin by less than the draws: b < 1."""
_LOW, _HIGH = 0.53, 1.7
"""Of 90 %."""
FITTED_TO = "tracker"
"""Sensor of the twins that they were fitted to: of a twin by IMU fewer errors are inside."""


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
    spread = max(float(np.mean(around**2)) - inside**2, 0.0)
    expected = float(np.sqrt(inside**2 + _SPREAD**2 * spread + (_RESIDUAL * residual) ** 2))
    return Prediction(
        uncorrected=uncorrected,
        inside=inside,
        expected=expected,
        low=_LOW * expected,
        high=_HIGH * expected,
    )
