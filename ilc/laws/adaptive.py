"""Learning gain adapted over the iterations and along the trajectory, after Norrloef (2002)."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..records import records
from .law import FilteredLaw

_FALSE_ALARM = 1e-4  # each one raises the gain again, which keeps noise


@dataclass(frozen=True, kw_only=True)
class Adaptive(FilteredLaw):
    """u_{k+1} = Q(u_k + kappa_k(t) L e_k), kappa the gain of a Kalman filter over iterations.

    The disturbance at each time t is modelled as a random walk over the iterations, observed with
    measurement noise: P <- P r_n / (P + r_n) + r_d, kappa = P / (P + r_n). The gain starts near
    1 and falls as the error becomes noise, which is then averaged instead of learned. r_d is
    estimated from the error power around t: where that exceeds P + r_n by more than noise does once
    in 10,000 samples, the gain rises again.
    Norrloef, "An adaptive iterative learning control algorithm with experiments on an industrial
    robot" (2002).
    """

    noise_variance: float
    initial_variance: float
    """r_n and P before the first iteration: variance of a measured sample, of the disturbance."""
    window: int = 25
    """Samples over which the error's power is averaged."""

    def __post_init__(self) -> None:
        for name in ("noise_variance", "initial_variance"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")
        if self.window < 1:
            raise ValueError(f"window must be >= 1 sample, got {self.window}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if self.window > n_samples:
            raise ValueError(f"window must be within {n_samples} samples, got {self.window}")
        super().check(n_samples, n_columns)

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: Array | None = None, /
    ) -> tuple[Array, Array]:
        """memory: P(t) after the last update, shape (N, n)."""
        P = np.full_like(error, self.initial_variance) if memory is None else memory
        r_n = self.noise_variance
        if memory is not None:
            power, expected = self._power(error), P + r_n
            changed = power > self._largest_by_chance(len(error)) * expected
            P = P + np.where(changed, power - expected, 0.0)
        kappa = P / (P + r_n)
        return self.Q(correction + kappa * self.L(error)), P * r_n / (P + r_n)

    def _power(self, error: Array) -> Array:
        """Moving average of e^2 around each sample."""
        box = np.ones(self.window)
        summed = [np.convolve(column, box, mode="same") for column in np.square(error).T]
        return np.stack(summed, axis=1) / self._count(len(error))[:, None]

    def _count(self, n_samples: int) -> Array:
        """Samples in the window around each sample."""
        return np.convolve(np.ones(n_samples), np.ones(self.window), mode="same")

    def _largest_by_chance(self, n_samples: int) -> Array:
        """Mean square of so much unit noise that is exceeded once in 10,000 samples, (N, 1)."""
        from scipy.special import gammaincinv

        half = 0.5 * self._count(n_samples)
        return (gammaincinv(half, 1.0 - _FALSE_ALARM) / half)[:, None]
