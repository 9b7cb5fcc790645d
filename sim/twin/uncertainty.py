"""Standard deviations of a twin's parameters, as estimates of those of a robot.

The covariance of identification is that of its linearised model. A robot differs from that model in
what no parameter stands for, such as a shifted centre of mass, and the estimates of mass, ripple
and stiffness take it in. The spread of true values around them is wider, at most that of the prior.
"""

import numpy as np

from armside.arrays import Array

from .parameters import Parameters

WIDER = 4.0
"""Smallest whole factor with which, of the identified parameters of individuals 1001 and 1004, four
cuts by tracker and by IMU, more than 92 % lie within 1.96 standard deviations by each sensor.
Individuals from 2001 on, of which nothing was chosen, test it."""
_IDENTIFIED = 0.7
"""Standard deviation of the linearised model over that of the prior, up to which the cuts tell of a
parameter. ESTIMATE."""


def standard_deviation(parameters: Parameters, covariance: Array) -> Array:
    """(m,), of the parameters of a robot about its twin's, for covariance (m, m)."""
    return np.minimum(WIDER * np.sqrt(np.diag(covariance)), parameters.standard_deviation)


def is_identified(parameters: Parameters, covariance: Array) -> np.ndarray:
    """(m,) bool: the cuts tell of a parameter, beyond the prior."""
    return np.sqrt(np.diag(covariance)) <= _IDENTIFIED * parameters.standard_deviation
