"""Vibration of a robot at rest, its motors off and on. Thesis 5.1.1, Fig. 5.2."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array

from ..instruments.imu import ImuSamples
from ..robot.virtual_robot import LOG_PERIOD, VirtualRobot
from .imu_experiment import sense
from .imu_specification import RestExperiment
from .phases import ImuRun, largest_gap

SETTLING_TIME = 0.5  # Left out after the motors are switched on [s]
SEGMENT = 2.0  # Segment of a power spectrum [s]: a resolution of 0.5 Hz
SLOWEST = 5.0  # Line of a spectrum [Hz]
QUANTILE = 0.997  # The level that a normal signal exceeds as rarely as three standard deviations


@dataclass(frozen=True)
class Rest:
    """Vibration at rest, motors off and on; x, y, z of the IMU [m/s^2]: RMS about the mean, spectra
    (F, 3) [(m/s^2)^2/Hz] over frequency (F,) [Hz]."""

    off_rms: Array
    on_rms: Array
    on_level: Array
    """Exceeded by 0.3 % of the samples."""
    frequency: Array
    off_spectrum: Array
    on_spectrum: Array


@dataclass(frozen=True)
class RestResult:
    """One experiment at rest, run and evaluated."""

    experiment: RestExperiment
    run: ImuRun
    rest: Rest
    loop_error: float
    """Widest opening of a closed chain [m]."""

    @property
    def entries(self) -> dict[str, Any]:
        """Entries of `summary.json`."""
        rest = self.rest
        spectra = zip("xyz", rest.on_spectrum.T, strict=True)
        peaks = {axis: lines(rest.frequency, density)[:5] for axis, density in spectra}
        levels = {"off_rms": rest.off_rms, "on_rms": rest.on_rms, "on_level": rest.on_level}
        return levels | {"loop_error": self.loop_error, "lines": peaks}


def run_rest(experiment: RestExperiment, seed: int = 0) -> RestResult:
    """Record the robot in the zero pose of thesis 5.1.1, or at its home: motors off, then on."""
    n = round((experiment.off + experiment.on) / LOG_PERIOD) + 1
    robot = VirtualRobot(experiment.model())
    loaded = robot.load(np.tile(experiment.home, (n, 1)), motors_on_at=experiment.off)
    run = sense(loaded, experiment.imu, seed)
    rest = at_rest(run.samples, experiment.off, experiment.imu.rate)
    return RestResult(experiment, run, rest, largest_gap(run.recording, loaded.model.mj))


def at_rest(samples: ImuSamples, motors_on_at: float, rate: float) -> Rest:
    """Vibration before and after the motors were switched on, [s] by the IMU's clock; rate: of the
    samples [Hz]."""
    off = samples.acceleration[samples.time < motors_on_at]
    on = samples.acceleration[samples.time >= motors_on_at + SETTLING_TIME]
    (frequency, off_spectrum), (_, on_spectrum) = (power_spectrum(a, rate) for a in (off, on))
    level = np.quantile(np.abs(on - on.mean(axis=0)), QUANTILE, axis=0)
    return Rest(off.std(axis=0), on.std(axis=0), level, frequency, off_spectrum, on_spectrum)


def power_spectrum(signal: Array, rate: float) -> tuple[Array, Array]:
    """Frequency (F,) [Hz] and one-sided power spectral density (F, n) [unit^2/Hz] of a signal
    (K, n) at a rate [Hz], by Welch's method: Hann windows that overlap by half."""
    from scipy.signal import welch

    n = round(SEGMENT * rate)
    frequency, density = welch(signal, rate, nperseg=n, noverlap=n - n // 2, axis=0)
    return np.asarray(frequency), np.asarray(density)


def lines(frequency: Array, density: Array) -> list[tuple[float, float]]:
    """Local maxima of a density (F,) above `SLOWEST`: frequency [Hz], height over the highest."""
    inner = np.flatnonzero((density[1:-1] > density[:-2]) & (density[1:-1] > density[2:])) + 1
    inner = inner[frequency[inner] > SLOWEST]
    order = inner[np.argsort(-density[inner])]
    return [(float(frequency[i]), float(density[i] / density[order[0]])) for i in order]
