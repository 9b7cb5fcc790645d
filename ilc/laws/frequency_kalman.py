"""Kalman filter over the iterations, one for each frequency: the gain that noise allows.

    kappa_k = P_k / (P_k + R)    u_{k+1} = u_k + L kappa_k e_k    P_{k+1} = kappa_k R + W

P is the power of what is not learned yet, R that of the noise, W that of what changes between
iterations. With W = 0 and P large kappa_k is 1 / (k + 1): all runs so far are averaged. After Saab,
"A discrete-time stochastic learning control algorithm" (2001), and Norrloef, "An adaptive iterative
learning control algorithm with experiments on an industrial robot" (2002), frequency by frequency.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import RecordFilter
from ..records import records
from .regularised_inverse import tapered

_AROUND = 5  # bins to each side over which a first power is averaged


@dataclass(frozen=True, kw_only=True, eq=False)
class FrequencyKalman:
    """Noise-optimal gain of each frequency and column. R is white, P_0 the power of e_0 less R."""

    L: RecordFilter
    """An inverse of T_u; whatever gain it has is taken to be right."""
    noise: float
    """Standard deviation of a measured sample, its part that does not repeat."""
    change: float = 0.0
    """Standard deviation of what changes from one iteration to the next."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.noise) and self.noise > 0.0):
            raise ValueError(f"noise must be > 0, got {self.noise}")
        if not (np.isfinite(self.change) and self.change >= 0.0):
            raise ValueError(f"change must be >= 0, got {self.change}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.L.check(n_samples, n_columns)

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: Array | None = None, /
    ) -> tuple[Array, Array]:
        """memory: P after the last update, (N + 1, n), at the frequencies of 2 N samples."""
        n = len(error)
        E = np.fft.rfft(tapered(error), axis=0)
        R, W = (2 * n * level**2 for level in (self.noise, self.change))
        P = np.maximum(_averaged(np.square(np.abs(E))) - R, 0.0) if memory is None else memory
        kappa = P / (P + R)
        learned = np.fft.irfft(kappa * E, 2 * n, axis=0)[:n]
        return correction + self.L(learned), P * R / (P + R) + W


def _averaged(power: Array) -> Array:
    """Moving average over neighbouring frequencies, which an estimate of power needs."""
    box = np.ones(2 * _AROUND + 1)
    count = np.convolve(np.ones(len(power)), box, mode="same")[:, None]
    return np.stack([np.convolve(p, box, mode="same") for p in power.T], axis=1) / count
