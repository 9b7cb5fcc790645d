"""Random signals with stated statistics. Each takes the Generator it draws from."""

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from armside.arrays import Array


def white(rng: np.random.Generator, shape: tuple[int, ...], std: ArrayLike) -> Array:
    """Independent normal samples; `std` is broadcast against `shape`."""
    return rng.standard_normal(shape) * np.asarray(std, dtype=np.float64)


def from_density(
    rng: np.random.Generator, shape: tuple[int, ...], density: ArrayLike, rate: float
) -> Array:
    """White noise sampled at `rate` [Hz], of one-sided `density` [units/sqrt(Hz)]: all of its power
    lies below the Nyquist frequency."""
    return white(rng, shape, np.asarray(density) * np.sqrt(rate / 2.0))


def band_limited(
    rng: np.random.Generator, shape: tuple[int, int], std: ArrayLike, bandwidth: float, step: float
) -> Array:
    """White noise through a first-order low-pass: a stationary process of standard deviation `std`.

    Its spectrum falls to half its power at `bandwidth` [Hz]; `shape` is (samples, channels),
    sampled every `step` [s]. x[i+1] = c x[i] + sqrt(1 - c^2) w, c = exp(-2 pi bandwidth step),
    exact at the samples whatever the step, and stationary from the first one.
    """
    if not (bandwidth > 0.0 and step > 0.0):
        raise ValueError(f"bandwidth and step must be > 0, got {bandwidth} Hz, {step} s")
    c = np.exp(-2.0 * np.pi * bandwidth * step)
    x = rng.standard_normal(shape)
    _correlate(x, c, np.sqrt(1.0 - c * c))
    return x * np.asarray(std, dtype=np.float64)


@njit(cache=True, nogil=True)
def _correlate(x: Array, c: float, fresh: float) -> None:  # pragma: no cover - compiled
    for i in range(1, x.shape[0]):
        for j in range(x.shape[1]):
            x[i, j] = c * x[i - 1, j] + fresh * x[i, j]


def random_walk(
    rng: np.random.Generator, shape: tuple[int, int], density: ArrayLike, step: float
) -> Array:
    """Random walk from 0 with variance density^2 t; `density` in units/sqrt(s)."""
    steps = white(rng, shape, np.asarray(density) * np.sqrt(step))
    steps[:1] = 0.0
    return np.cumsum(steps, axis=0)


def stride(record_rate: float, rate: float) -> int:
    """Rows of a record per sample of an instrument; ValueError unless its rate [Hz] divides."""
    if not (rate > 0.0 and record_rate > 0.0):
        raise ValueError(f"rates must be > 0 Hz, got {rate} and {record_rate}")
    every = round(record_rate / rate)
    if every < 1 or abs(every * rate - record_rate) > 1e-6 * record_rate:
        raise ValueError(f"rate {rate:g} Hz must divide the {record_rate:g} Hz of the record")
    return every


def rate_of(time: Array) -> float:
    """Rate [Hz] of a uniform time axis, which needs two samples at least."""
    if len(time) < 2:
        raise ValueError(f"a rate needs at least 2 samples, got {len(time)}")
    return float((len(time) - 1) / (time[-1] - time[0]))
