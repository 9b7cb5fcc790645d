"""Observation of the env: signals of a robot cell after a run, as in the table of
`armside.sim.tuning.env.IlcTuningEnv`. The tool's true position is no part of it.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.measures.norms import two_norm

from ..robot.six_axes import N_AXES
from ..robot.virtual_robot import LOG_PERIOD
from .situation import Situation


@dataclass(frozen=True)
class Feature:
    """Some entries of the observation and the range that [-1, 1] stands for."""

    name: str
    size: int
    unit: str
    low: float
    high: float
    logarithmic: bool = True


BANDS = ((0.0, 3.0), (3.0, 8.0), (8.0, 16.0), (16.0, 125.0))
"""[Hz]"""

FEATURES = (
    Feature("motor error, 2-norm over the record", N_AXES, "rad", 1e-3, 1e2),
    Feature("motor error, infinity-norm", N_AXES, "rad", 1e-4, 1e1),
    *(
        Feature(f"motor error, RMS in {low:g}-{high:g} Hz", N_AXES, "rad", 1e-6, 1e1)
        for low, high in BANDS
    ),
    Feature("correction, 2-norm over the record", N_AXES, "rad", 1e-3, 1e2),
    Feature("joint position at the start, motors, arm side", N_AXES, "rad", -6.2832, 6.2832, False),
    Feature("commanded speed", 1, "m/s", 0.0, 0.1, False),
    Feature("iteration k", 1, "-", 0.0, 10.0, False),
)
SIZE = sum(feature.size for feature in FEATURES)


def _per_entry(values: Iterable[float]) -> Array:
    return np.repeat(np.array(list(values)), [feature.size for feature in FEATURES])


_LOGARITHMIC = _per_entry(f.logarithmic for f in FEATURES)
_LOW = _per_entry(np.log(f.low) if f.logarithmic else f.low for f in FEATURES)
_HIGH = _per_entry(np.log(f.high) if f.logarithmic else f.high for f in FEATURES)


def normalised(values: Array) -> Array:
    """Physical values (..., 50) to [-1, 1], clipped; not finite becomes +1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = np.where(_LOGARITHMIC, np.log(values), values)
    part = np.where(np.isfinite(values), (scaled - _LOW) / (_HIGH - _LOW), 1.0)
    return 2.0 * np.clip(part, 0.0, 1.0) - 1.0


def band_rms(signal: Array, period: float, bands: tuple[tuple[float, float], ...]) -> Array:
    """(len(bands), n): the part of each column's RMS that lies in each band [low, high) Hz.

    signal: (N, n), one row each `period` [s]. The Nyquist frequency counts to a band that ends
    there.
    """
    n = len(signal)
    power = np.abs(np.fft.rfft(signal, axis=0) / n) ** 2
    power[1 : (n + 1) // 2] *= 2.0  # both halves of the spectrum, mean and Nyquist but once
    frequency = np.fft.rfftfreq(n, period)
    nyquist = 0.5 / period
    inside = [(frequency >= low) & ((frequency < high) | (high >= nyquist)) for low, high in bands]
    return np.sqrt(np.stack([power[band].sum(axis=0) for band in inside]))


def observation(situation: Situation) -> np.ndarray:
    """(50,) float32 in [-1, 1], as `FEATURES` says."""
    loaded = situation.experiment.loaded
    values = (
        situation.two_norm,
        situation.inf_norm,
        *band_rms(situation.motor_error, LOG_PERIOD, BANDS),
        two_norm(situation.correction * loaded.model.drives.gear),
        loaded.reference[0],
        np.array([situation.experiment.motion.programmed_speed]),
        np.array([float(situation.k)]),
    )
    return normalised(np.concatenate(values)).astype(np.float32)
