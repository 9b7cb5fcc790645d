"""Random-phase multisines: periodic inputs with power at chosen lines of the spectrum only.

    u(t) = sum over lines k of A_k cos(2 pi k t / N + phase)

One period has N samples, so whole periods in steady state have no leakage. n inputs need n
experiments; their phases make U(k), inputs by experiments, a multiple of a unitary matrix at each
line (Dobrowiecki and Schoukens, "Measuring a linear approximation to weakly nonlinear MIMO
systems", Automatica 43, 2007): no inputs of this power determine it
better.
"""

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_real


def lines_between(low: float, high: float, period: int, sample_time: float) -> list[int]:
    """Lines of a period of `period` samples from `low` to `high` [Hz], ends included.

    Raises ValueError for a band without lines, or one that reaches 0 or the Nyquist frequency.
    """
    step = 1.0 / (period * sample_time)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    if not 1 <= first <= last <= (period - 1) // 2:
        raise ValueError(
            f"the band must hold lines k / {period * sample_time:g} s above 0 and below "
            f"{0.5 / sample_time:g} Hz, got {low:g} to {high:g} Hz"
        )
    return list(range(first, last + 1))


def orthogonal_multisines(
    period: int,
    lines: ArrayLike,
    n_inputs: int,
    rng: np.random.Generator,
    *,
    rms: ArrayLike = 1.0,
) -> Array:
    """One period of n experiments with n inputs, shape (n, period, n): experiment, time, input.

    Args:
        lines: (M,) harmonics of the period, each from 1 to below period / 2.
        rng: draws the phases; new ones are another realisation of the same power.
        rms: of each input, one value or (n,).

    Raises:
        ValueError: for lines outside of that range, or an RMS that is not positive.
    """
    k, size = harmonics(lines, period), np.broadcast_to(as_real(rms, "rms"), (n_inputs,))
    if not (np.isfinite(size).all() and (size > 0.0).all()):
        raise ValueError(f"rms must be > 0, got {rms}")
    turns = np.outer(np.arange(n_inputs), np.arange(n_inputs)) / n_inputs  # input, experiment
    phases = 2 * np.pi * (rng.uniform(size=(len(k), n_inputs, 1)) + turns)
    spectrum = np.zeros((period // 2 + 1, n_inputs, n_inputs), dtype=np.complex128)
    spectrum[k] = np.exp(1j * phases) * (size * np.sqrt(0.5 / len(k)) * period)[:, None]
    return np.fft.irfft(spectrum, period, axis=0).transpose(2, 0, 1)


def harmonics(lines: ArrayLike, period: int) -> np.ndarray:
    """Lines (M,) of a period as integers; ValueError unless each is from 1 to below period / 2."""
    k = as_real(lines, "lines")
    is_line = k.ndim == 1 and k.size > 0 and np.array_equal(k, np.round(k))
    if not is_line or len(np.unique(k)) < k.size or k.min() < 1 or 2 * k.max() >= period:
        raise ValueError(
            f"lines must be different whole numbers from 1 to below {period / 2:g}, half a period"
        )
    return k.astype(np.int64)
