"""Regularised inverse of a plant that varies along the trajectory.

    u_{k+1} = Q (u_k + gamma sum_s w_s(t) L_s e_k)

L_s inverts the response of the plant at one place, w_s are weights that fade from each place to the
next. As slow as a place is left, as right is the inverse. Q removes what lies above its cutoff, so
the L_s are computed for the frequencies that it passes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from armside.arrays import Array

from ..models.system import Complex
from ..records import records
from .law import FirstOrderLaw
from .regularised_inverse import RegularisedInverse, tapered

_PASSED = 1e-3
"""Gain of Q below which nothing is learned."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScheduledInverse(FirstOrderLaw):
    """Law for errors (N, p) and corrections (N, n) of one record."""

    laws: tuple[RegularisedInverse, ...]
    """Of each place; Q, gain and limit of the first serve all."""
    weights: Array
    """(N, S), >= 0, rows of sum 1."""

    def __post_init__(self) -> None:
        if self.weights.ndim != 2 or self.weights.shape[1] != len(self.laws):
            shape = f"(N, {len(self.laws)})"
            raise ValueError(f"weights must have shape {shape}, got {self.weights.shape}")
        if not np.allclose(self.weights.sum(axis=1), 1.0):
            raise ValueError("weights of each sample must have the sum 1")

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.weights) != n_samples:
            raise ValueError(f"weights cover {len(self.weights)} samples, the record {n_samples}")
        self.laws[0].check(n_samples, n_columns)

    @cached_property
    def _passed(self) -> Array:
        """(M,) [rad/sample], frequencies of the tapered record that Q passes."""
        omega: Array = 2.0 * np.pi * np.fft.rfftfreq(2 * len(self.weights)).astype(np.float64)
        return omega[: int((self.laws[0].Q(omega) > _PASSED).sum())]

    @cached_property
    def _inverses(self) -> list[Complex]:
        return [law.L(self._passed) for law in self.laws]

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        n, first = len(correction), self.laws[0]
        E = np.fft.rfft(tapered(error), axis=0)[: len(self._passed), :, None]
        learned = np.zeros_like(correction)
        for weight, L in zip(self.weights.T, self._inverses, strict=True):
            spectrum = np.zeros((n + 1, correction.shape[1]), dtype=np.complex128)
            spectrum[: len(self._passed)] = (L @ E)[:, :, 0]
            learned += weight[:, None] * np.fft.irfft(spectrum, 2 * n, axis=0)[:n]
        wanted = np.fft.rfft(tapered(correction + first.gamma * learned), axis=0)
        omega = 2.0 * np.pi * np.fft.rfftfreq(2 * n)
        u = np.fft.irfft(first.Q(omega)[:, None] * wanted, 2 * n, axis=0)[:n]
        largest = first.limit * np.array(first.input_size)
        return np.clip(u, -largest, largest)
