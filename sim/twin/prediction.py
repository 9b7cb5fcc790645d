"""Predicted tool error of a corrected first run, with an interval.

    expected^2 = e^2 + b^2 (s^2 - e^2) + (a h)^2        interval = expected * (low, high)

e is the error inside the twin, s the root mean square error of the individuals around it, h the
residual of cuts that the twin was not identified from. a, b, low and high were fitted to cuts of
individuals among `DEVELOPMENT` of `armside verify first-cut`, which are not the judged ones.
Errors of one individual resemble each other. By the tracker, low and high are such that 90 % of the
errors of each are inside those of the others: fourteen cuts each of 1001, 1003, 1004, 1006, 1007,
1009, 1010 and 1012. By an IMU the geometry that it does not see makes individuals differ more:
log(error / expected) of sixteen cuts each of all twelve has a standard deviation of 0.31 within an
individual and 0.18 between them, and low and high are those of a normal prediction for another
individual (Student's t, eleven degrees of freedom, for the part between).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from .sensors import Measure

_RESIDUAL, _SPREAD = 0.3, 0.4
"""a and b. Individuals differ from the twin by less than the draws: b < 1."""
_FACTORS: Mapping[Measure, tuple[float, float]] = {"tracker": (0.53, 1.7), "imu": (0.57, 1.92)}
"""low and high of 90 %, by the sensor that the twin was identified from."""


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


def predicted(
    uncorrected: float, inside: float, around: Array, residual: float, sensor: Measure
) -> Prediction:
    """Prediction from errors around the twin (n,) [m] and the residual of held-out cuts [m]."""
    low, high = _FACTORS[sensor]
    spread = max(float(np.mean(around**2)) - inside**2, 0.0)
    expected = float(np.sqrt(inside**2 + _SPREAD**2 * spread + (_RESIDUAL * residual) ** 2))
    return Prediction(
        uncorrected=uncorrected,
        inside=inside,
        expected=expected,
        low=low * expected,
        high=high * expected,
    )
