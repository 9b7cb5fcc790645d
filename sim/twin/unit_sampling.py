"""Readings of an accelerometer without errors: its low-pass, and its instants on another clock."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..instruments.imu import TriadCfg


@dataclass(frozen=True, eq=False)
class UnitSampling:
    """A triad as its data sheet has it."""

    triad: TriadCfg
    time: Array
    """(K,) [s], of its samples, on its own clock."""

    def __call__(self, ideal: Array, step: float, offset: float) -> Array:
        """Readings (K, 3, ...) of ideal ones (M, 3, ...), which start at robot time 0.

        step: between ideal readings [s]. offset: robot time less unit time [s].
        """
        filtered = self.filtered(ideal, step)
        at = np.clip((self.time + offset) / step, 0.0, len(ideal) - 1.0)
        i = np.minimum(at.astype(int), len(ideal) - 2)
        fraction = (at - i).reshape(-1, *[1] * (ideal.ndim - 1))
        return np.asarray((1.0 - fraction) * filtered[i] + fraction * filtered[i + 1])

    def filtered(self, ideal: Array, step: float) -> Array:
        """Ideal readings (M, 3, ...) through the low-pass, from rest."""
        moved = (ideal - ideal[0]).reshape(len(ideal), -1)
        return ideal[0] + self.triad.low_passed(moved, step).reshape(ideal.shape)
