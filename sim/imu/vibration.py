"""Vibration of a robot at rest, its motors off and on. Thesis 5.1.1, Fig. 5.2."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..instruments.imu import ImuSamples

SETTLED = 0.5
"""After the motors are switched on, before it counts [s]."""
SEGMENT = 2.0
"""Of a power spectrum [s]: lines 0.5 Hz apart are told apart."""
QUANTILE = 0.997
"""The level that a normal signal exceeds as rarely as three standard deviations."""


@dataclass(frozen=True, kw_only=True)
class Rest:
    """Accelerations at rest; vectors are x, y, z."""

    off_rms: Array
    """[m/s^2], about the mean."""
    on_rms: Array
    """[m/s^2]."""
    on_level: Array
    """[m/s^2], exceeded by 0.3 % of the samples."""
    frequency: Array
    """(F,) [Hz]."""
    off_spectrum: Array
    """(F, 3) [(m/s^2)^2/Hz]."""
    on_spectrum: Array
    """(F, 3) [(m/s^2)^2/Hz]."""


def at_rest(samples: ImuSamples, motors_on_at: float, rate: float) -> Rest:
    """What an IMU felt before and after the motors were switched on.

    motors_on_at: [s], by the IMU's clock. rate: of the samples [Hz].
    """
    off = samples.acceleration[samples.time < motors_on_at]
    on = samples.acceleration[samples.time >= motors_on_at + SETTLED]
    frequency, on_spectrum = power_spectrum(on, rate)
    return Rest(
        off_rms=off.std(axis=0),
        on_rms=on.std(axis=0),
        on_level=np.quantile(np.abs(on - on.mean(axis=0)), QUANTILE, axis=0),
        frequency=frequency,
        off_spectrum=power_spectrum(off, rate)[1],
        on_spectrum=on_spectrum,
    )


def power_spectrum(signal: Array, rate: float) -> tuple[Array, Array]:
    """One-sided power spectral density by Welch's method: Hann windows that overlap by half.

    Args:
        signal: (K, n), sampled at `rate` [Hz], at least one segment long.

    Returns:
        Frequency (F,) [Hz] and density (F, n) [unit^2/Hz].
    """
    n = round(SEGMENT * rate)
    if len(signal) < n:
        raise ValueError(f"a spectrum needs {SEGMENT:g} s of samples, got {len(signal) / rate:g} s")
    window = np.sin(np.pi * np.arange(n) / n)[:, None] ** 2
    starts = range(0, len(signal) - n + 1, n // 2)
    segments = np.stack([signal[i : i + n] - signal[i : i + n].mean(axis=0) for i in starts])
    power = np.mean(np.abs(np.fft.rfft(segments * window, axis=1)) ** 2, axis=0)
    density = power / (rate * np.sum(window**2))
    density[1 : (n + 1) // 2] *= 2.0
    return np.arange(n // 2 + 1, dtype=np.float64) * (rate / n), density


def lines(frequency: Array, density: Array, *, above: float = 5.0) -> list[tuple[float, float]]:
    """Local maxima of one density (F,) above a frequency [Hz]: (frequency, height), highest first.

    Heights are relative to the highest.
    """
    inner = np.flatnonzero((density[1:-1] > density[:-2]) & (density[1:-1] > density[2:])) + 1
    inner = inner[frequency[inner] > above]
    order = inner[np.argsort(-density[inner])]
    return [(float(frequency[i]), float(density[i] / density[order[0]])) for i in order]
