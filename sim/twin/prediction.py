"""Predicted tool error of a corrected first run, with an interval.

    r^2 = e^2 + b^2 (s^2 - e^2) + (a h)^2        expected and interval: r (middle, low, high)

e is the error inside the twin, s the root mean square error of the individuals around it, h the
residual of cuts that the twin was not identified from. a, b and the factors were fitted to cuts of
individuals among `DEVELOPMENT` of `make claims NAME=first-cut`, which are not the judged ones.
Errors of one individual resemble each other.

By the tracker the factors are such that 90 % of the errors of each are inside those of the others:
fourteen cuts each of 1001, 1003, 1004, 1006, 1007, 1009, 1010 and 1012. Of fewer cuts h, the
residual of twins of one cut less, says more than the twin leaves. By an IMU and ten cuts the
geometry that it does not see makes individuals differ more: log(error / r) of sixteen cuts each of
all twelve has a standard deviation of 0.31 within an individual and 0.18 between them, and low and
high are those of a normal prediction for another individual (Student's t, eleven degrees of
freedom, for the part between).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from .sensors import Measure

_RESIDUAL, _SPREAD = 0.3, 0.4
"""a and b. Individuals differ from the twin by less than the draws: b < 1."""


class Factors(NamedTuple):
    """Expected error and its interval of 90 %, over r."""

    low: float
    middle: float
    high: float


_FACTORS: Mapping[Measure, Mapping[int, Factors]] = {
    "tracker": {
        10: Factors(0.53, 1.0, 1.7),
        4: Factors(0.36, 0.84, 1.42),
        2: Factors(0.24, 0.5, 0.94),
    },
    "imu": {10: Factors(0.57, 1.0, 1.92)},
}
"""By the sensor and the number of cuts that the twin was identified from."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What a twin was identified from, and what it leaves of a cut that it was not."""

    sensor: Measure
    n_cuts: int
    residual: float
    """[m]."""

    @property
    def factors(self) -> Factors:
        """Those of the largest number of cuts that is not above n_cuts; of the most below all."""
        known = _FACTORS[self.sensor]
        return known[max((n for n in known if n <= self.n_cuts), default=max(known))]

    @property
    def is_calibrated(self) -> bool:
        """True where the factors are those of twins of so many cuts or fewer."""
        return self.n_cuts >= min(_FACTORS[self.sensor])


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
    calibrated: bool
    """The interval was fitted to twins like this one."""


def predicted(uncorrected: float, inside: float, around: Array, evidence: Evidence) -> Prediction:
    """Prediction from errors in the twin and around it, (n,), all in m."""
    spread = max(float(np.mean(around**2)) - inside**2, 0.0)
    variance = inside**2 + _SPREAD**2 * spread + (_RESIDUAL * evidence.residual) ** 2
    r, factors = float(np.sqrt(variance)), evidence.factors
    return Prediction(
        uncorrected=uncorrected,
        inside=inside,
        expected=factors.middle * r,
        low=factors.low * r,
        high=factors.high * r,
        calibrated=evidence.is_calibrated,
    )
