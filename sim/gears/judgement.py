"""Judgement of a transmission error on a recording that it was not learned from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..recordings.alignment.encoder_motion import RATE, bandpass
from .aligned import EDGE, Aligned
from .observation import Observation
from .transmission import Transmission

JUDGED_FROM = 0.5
"""Fraction of a recording from which a tracker judges; clock, base and tool are of that before."""
FLOOR_BAND = (22.0, 35.0)
"""[Hz] Band in which a tracker sees its own noise alone; taken as white."""


@dataclass(frozen=True, eq=False)
class Remaining:
    """Error at the tool in a band of frequency that the tracker sees, and what a model leaves."""

    rms: Array
    """(3,) [m], encoders alone, base axes."""
    ratio: Array
    """(3,), RMS with the model over RMS without."""
    pooled: float
    """The same over all axes."""
    floor: Array
    """(3,) [m], noise of the tracker in that band."""


def sensor_ratio(found: Transmission, one: Observation) -> float:
    """RMS of the sensor's weighted residual with the transmission error, over that without."""
    terms = zip(found.joints, found.orders, found.coefficients, strict=True)
    model = sum((one.columns(joint, order) @ x for joint, order, x in terms), np.zeros(()))
    left = np.abs(one.target - model) ** 2
    return float(np.sqrt(left.sum() / (np.abs(one.target) ** 2).sum()))


def judged_rows(aligned: Aligned) -> NDArray[np.bool_]:
    """(M,) bool, samples on which a tracker judges."""
    rows = aligned.tool_residual()[1].copy()
    rows[: int(JUDGED_FROM * len(rows))] = False
    rows[-int(EDGE * RATE) :] = False
    return rows


def remaining(
    residual: Array, estimate: Array, rows: NDArray[np.bool_], band: tuple[float, float]
) -> Remaining:
    """What an estimate (M, 3) [m] of the tool's error leaves of the one that a tracker saw."""
    seen, left = (bandpass(x, *band)[rows] for x in (residual, residual - estimate))
    width = (band[1] - band[0]) / (FLOOR_BAND[1] - FLOOR_BAND[0])
    noise = bandpass(residual, *FLOOR_BAND)[rows]
    return Remaining(
        rms=_rms(seen),
        ratio=_rms(left) / _rms(seen),
        pooled=float(np.sqrt((left**2).sum() / (seen**2).sum())),
        floor=np.sqrt(width) * _rms(noise),
    )


def _rms(x: Array) -> Array:
    return np.sqrt((x**2).mean(axis=0))


BANDS = ((0.7, 2.0), (2.0, 4.0), (4.0, 8.0), (8.0, 12.0), (12.0, 16.0))
"""[Hz] In which an estimate is stated beside the band of judgement."""
SEGMENT = 5.12
"""[s] Of a spectrum's averages."""


@dataclass(frozen=True, kw_only=True)
class InBand:
    """Error of the tool that a tracker sees in one band, all axes."""

    band: tuple[float, float]
    """[Hz]."""
    rms: float
    """[m], root mean square of the distance, by encoders alone."""
    floor: float
    """[m], noise of the tracker, in the same measure."""
    gears: float
    """RMS with the transmission error over RMS without."""
    fused: float | None
    """The same with the IMU smoothed in; None without IMU."""

    def beyond_floor(self, ratio: float) -> float:
        """The ratio after the noise of the tracker, that no estimate can remove, is taken off."""
        noise = (self.floor / self.rms) ** 2
        return float(np.sqrt(max(0.0, ratio**2 - noise) / max(1.0 - noise, np.finfo(float).eps)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Spectra:
    """Amplitude densities of the tool's error by a tracker, (F,) [m/sqrt(Hz)], all axes."""

    frequency: Array
    encoders: Array
    gears: Array
    fused: Array | None


def in_bands(
    residual: Array,
    gears: Array,
    fused: Array | None,
    rows: NDArray[np.bool_],
    bands: Sequence[tuple[float, float]] = BANDS,
) -> tuple[InBand, ...]:
    """What the estimates (M, 3) [m] leave of a tracker's residual (M, 3) [m] in each band."""

    def one(band: tuple[float, float]) -> InBand:
        left = remaining(residual, gears, rows, band)
        both = None if fused is None else remaining(residual, fused, rows, band).pooled
        return InBand(
            band=band,
            rms=_distance(left.rms),
            floor=_distance(left.floor),
            gears=left.pooled,
            fused=both,
        )

    return tuple(one(band) for band in bands)


def spectra(residual: Array, gears: Array, fused: Array | None, rows: NDArray[np.bool_]) -> Spectra:
    """Spectra of a tracker's residual and of what the estimates leave of it."""
    frequency, encoders = _density(residual[rows])
    both = None if fused is None else _density((residual - fused)[rows])[1]
    gear = _density((residual - gears)[rows])[1]
    return Spectra(frequency=frequency, encoders=encoders, gears=gear, fused=both)


def _density(x: Array) -> tuple[Array, Array]:
    from scipy.signal import welch

    frequency, power = welch(x, RATE, nperseg=int(SEGMENT * RATE), detrend="linear", axis=0)
    return np.asarray(frequency), np.sqrt(power.sum(axis=1))


def _distance(axes: Array) -> float:
    return float(np.linalg.norm(axes))
