"""Judgement of a transmission error on a recording that it was not learned from.

Beside the encoders stands an estimate with the IMU smoothed in, without a tracker: what the
accelerometer sees beyond the transmission error is integrated twice in the frequency domain, where
it stands out from its own noise (a Wiener smoother of the same second moments):

    p(f) = -W(f) / (2 pi f)^2 a(f),   W = max(0, 1 - S_noise / S(f))

S is the smoothed power of a, S_noise its mean over 3 to 5.5 Hz, where the tool hardly vibrates.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..recordings.alignment.encoder_motion import RATE, bandpass
from ..recordings.alignment.imu_alignment import GRAVITY
from .aligned import EDGE, Aligned
from .residual_spectra import Observation, smoothed, tapered
from .transmission import Transmission

QUIET = (3.0, 5.5)
"""[Hz] Where the accelerometer's residual is its noise. Of the trial on the AUBO (docs/real.md)."""
BAND = (2.5, 16.0)
"""[Hz] That is integrated."""
SMOOTHED = 1.0
"""[Hz] Width over which the power is averaged. ESTIMATE."""
SHOCK = 8.0
"""Acceleration, in robust standard deviations, that is a shock or a dropout of the IMU."""
BLANKED = 0.3
"""[s] On either side of a shock that is not integrated."""


def fused(aligned: Aligned, found: Transmission) -> Array:
    """(M, 3) [m], error of the tool that the encoders do not see, base axes, with an IMU."""
    from scipy.fft import irfft, rfft, rfftfreq

    assert aligned.imu is not None
    assert aligned.recording.imu is not None
    motion = aligned.motion
    seen = aligned.imu.covered(motion, aligned.recording.imu)
    residual = aligned.imu.residual(motion, aligned.recording.imu)[:, :3]
    first, last = np.flatnonzero(seen)[[0, -1]].tolist()
    window = (tapered(len(seen), first, last, RATE) * _undisturbed(residual))[:, None]
    f = np.asarray(rfftfreq(len(motion.time), 1.0 / RATE), dtype=np.float64)
    # Less what the transmission error adds to the accelerometer.
    moved = found.tool_error(motion, aligned.imu.lever).sum(axis=2)
    turned = np.einsum("mij,mj->mi", motion.J[:, 3:], found(motion.phi))
    tilt = np.asarray(rfft(window * np.cross(turned, GRAVITY), axis=0))
    of_gears = tilt - (2.0 * np.pi * f[:, None]) ** 2 * np.asarray(rfft(window * moved, axis=0))
    a = np.asarray(rfft(window * residual, axis=0)) - of_gears
    inside = (f >= BAND[0]) & (f <= BAND[1])
    power = smoothed(np.abs(a) ** 2, int(SMOOTHED * len(motion.time) / RATE) // 2)
    noise = power[(f >= QUIET[0]) & (f <= QUIET[1])].mean(axis=0)
    W = np.clip(1.0 - noise / np.maximum(power, np.finfo(float).tiny), 0.0, 1.0)
    omega = 2.0 * np.pi * np.maximum(f, BAND[0])[:, None]
    vibration = irfft(np.where(inside[:, None], -W / omega**2 * a, 0.0), len(seen), axis=0)
    gear = found.tool_error(motion, aligned.target).sum(axis=2)
    return gear + np.asarray(vibration)


def _undisturbed(residual: Array) -> Array:
    """Window (M,) that fades to zero around shocks."""
    off = np.abs(residual - np.median(residual, axis=0))
    shock = (off > SHOCK * 1.4826 * np.median(off, axis=0)).any(axis=1)
    width = int(BLANKED * RATE)
    near = np.convolve(shock, np.ones(4 * width + 1), "same") > 0.0
    fade = np.hanning(2 * width + 1)
    return 1.0 - np.convolve(near, fade / fade.sum(), "same")


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
    residual: Array, gears: Array, fused: Array | None, rows: NDArray[np.bool_]
) -> tuple[InBand, ...]:
    """What the estimates (M, 3) [m] leave of a tracker's residual (M, 3) [m] in each band."""
    found = []
    for band in BANDS:
        left = remaining(residual, gears, rows, band)
        found.append(
            InBand(
                band=band,
                rms=float(np.linalg.norm(left.rms)),
                floor=float(np.linalg.norm(left.floor)),
                gears=left.pooled,
                fused=None if fused is None else remaining(residual, fused, rows, band).pooled,
            )
        )
    return tuple(found)


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
