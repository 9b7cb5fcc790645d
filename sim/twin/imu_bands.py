"""Octaves of an IMU's readings, without what the unit's own errors explain."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..instruments.imu import ImuCfg, TriadCfg
from .unit_errors import unit_errors

_ORDER = 3
"""Of one pass of the low-passes at a band's edges."""


@dataclass(frozen=True, eq=False)
class TriadBands:
    """Bands of one triad's readings."""

    cfg: ImuCfg
    triad: TriadCfg
    edges: tuple[float, ...]
    """Upper edges [Hz], ascending; the first band starts at zero."""
    time: Array
    """(K,) [s], of the samples."""
    expected: Array
    """(K, 3), readings of a perfect unit, to which those of this one are nearly equal."""

    def __call__(self, reading: Array) -> Array:
        """(K, 3 bands, m) of readings (K, 3, m), in units of the data sheet's white noise.

        The unit's errors are projected out of every band, weighed by what its data sheet allows.
        """
        parts = zip(self._split(reading), self._errors, strict=True)
        return np.concatenate([_without(band, *errors) for band, errors in parts], axis=1)

    def _split(self, reading: Array) -> list[Array]:
        period = 1.0 / self.cfg.rate
        noise = self.triad.noise_density * np.sqrt(0.5 / period)
        columns = reading.reshape(len(reading), -1) / noise
        low = [ZeroPhaseButterworth(edge, period, _ORDER)(columns) for edge in self.edges]
        bands = [low[0], *(above - below for below, above in pairwise(low))]
        return [band.reshape(reading.shape) for band in bands]

    @cached_property
    def _errors(self) -> list[tuple[Array, Array]]:
        """Of each band: columns (3 K, e) of the unit's errors, and the matrix that fits them."""
        columns, deviation = unit_errors(self.time, self.expected, self.cfg, self.triad)
        prior = np.diag(deviation**-2.0)
        return [_fitting(band.reshape(-1, len(deviation)), prior) for band in self._split(columns)]


def _fitting(errors: Array, prior: Array) -> tuple[Array, Array]:
    return errors, np.asarray(np.linalg.solve(errors.T @ errors + prior, errors.T), np.float64)


def _without(band: Array, errors: Array, fit: Array) -> Array:
    flat = band.reshape(len(errors), -1)
    return (flat - errors @ (fit @ flat)).reshape(band.shape)
