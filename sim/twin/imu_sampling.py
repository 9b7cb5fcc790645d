"""Readings of an IMU without errors: its low-passes and its instants on another clock."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..instruments.imu import ImuCfg, TriadCfg


@dataclass(frozen=True, eq=False)
class ImuSampling:
    """A unit as its data sheet has it."""

    cfg: ImuCfg
    time: Array
    """(K,) [s], of its samples, on its own clock."""

    def __call__(self, ideal: Array, step: float, offset: float) -> Array:
        """Readings (K, 6, ...) of ideal ones (M, 6, ...), which start at robot time 0.

        step: between ideal readings [s]. offset: robot time less unit time [s].
        """
        filtered = self.filtered(ideal, step)
        at = np.clip((self.time + offset) / step, 0.0, len(ideal) - 1.0)
        i = np.minimum(at.astype(int), len(ideal) - 2)
        fraction = (at - i).reshape(-1, *[1] * (ideal.ndim - 1))
        return np.asarray((1.0 - fraction) * filtered[i] + fraction * filtered[i + 1])

    def filtered(self, ideal: Array, step: float) -> Array:
        """Ideal readings (M, 6, ...) through the low-passes of both triads, from rest."""
        triads = zip((self.cfg.accelerometer, self.cfg.gyroscope), halves(ideal), strict=True)
        return np.concatenate([_from_rest(triad, part, step) for triad, part in triads], axis=1)


def halves(reading: Array) -> list[Array]:
    """Accelerations and angular velocities, (K, 3, ...) each, of readings (K, 6, ...)."""
    return np.split(reading, 2, axis=1)


def _from_rest(triad: TriadCfg, ideal: Array, step: float) -> Array:
    moved = (ideal - ideal[0]).reshape(len(ideal), -1)
    return ideal[0] + triad.low_passed(moved, step).reshape(ideal.shape)
