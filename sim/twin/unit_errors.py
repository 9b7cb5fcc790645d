"""Errors of an accelerometer that look like motion: clock, bias, mounting, scale, misalignment."""

import numpy as np

from armside.arrays import Array

from ..instruments.imu import ImuCfg

_FREE = 1e3
"""Standard deviation of bias and its drift [m/s^2]: nothing is known of them."""
_EXACT = 1e-9
"""Standard deviation of what a data sheet says to be exact."""


def unit_errors(time: Array, reading: Array, cfg: ImuCfg) -> tuple[Array, Array]:
    """Columns (K, 3, 19) [m/s^2] of the errors, and their standard deviations (19,).

    Bias and its drift, mounting, scale and misalignment, clock. reading: (K, 3), of the unit: its
    errors are small.
    """
    n, unit, triad = len(reading), np.eye(3), cfg.accelerometer
    ramp = np.linspace(-1.0, 1.0, n)
    bias = np.concatenate((np.tile(unit, (n, 1, 1)), ramp[:, None, None] * unit), axis=2)
    mounting = np.stack([np.cross(reading, axis) for axis in unit], axis=2)
    sensitivity = (unit[None, :, :, None] * reading[:, None, None, :]).reshape(n, 3, 9)
    clock = np.gradient(reading, time, axis=0)[:, :, None]
    errors = np.where(unit > 0.0, triad.scale_error, triad.misalignment).ravel()
    known = np.concatenate((np.full(3, cfg.mounting_error), errors, [cfg.clock_offset]))
    deviation = np.concatenate((np.full(6, _FREE), np.maximum(known, _EXACT)))
    return np.concatenate((bias, mounting, sensitivity, clock), axis=2), deviation
