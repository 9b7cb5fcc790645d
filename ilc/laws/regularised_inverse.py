"""Regularised inverse of a frequency response, for several outputs and inputs.

    U_{k+1} = Q (U_k + gamma L E_k)        L = (G^H W G + rho S^-2)^-1 G^H W

W weights the outputs and S scales the inputs: of all corrections with the same effect the law
chooses the one with the smallest norm in S. G need be neither square nor invertible. The record is
extended by a taper from its last value to its first, which leaves no step for L to amplify.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex
from ..records import records
from .law import FirstOrderLaw


class Response(Protocol):
    """Linear model with a frequency response."""

    def response(self, omega: ArrayLike) -> Complex:
        """(M, p, n) at omega (M,) [rad/sample]."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class RegularisedInverse(FirstOrderLaw):
    """First-order law from errors of p outputs, (N, p), to corrections of n inputs, (N, n)."""

    G: Response
    """Response of the output to the correction."""
    sample_time: float
    cutoff: float
    """[Hz] of Q = 1 / (1 + (f / cutoff)^sharpness), which has no phase."""
    sharpness: int = 8
    gamma: float = 0.8
    """Learning gain, in (0, 2)."""
    output_weight: tuple[float, ...]
    input_size: tuple[float, ...]
    """(n,), diagonal of S, > 0; weights: (p,), roots of W's diagonal, 0 for no learning."""
    regularisation: float = 0.01
    """rho relative to the largest static gain of W^1/2 G S, squared."""
    limit: float = np.inf
    """Largest correction of each input, relative to its size."""

    def __post_init__(self) -> None:
        if not 0.0 < self.cutoff < (top := 0.5 / self.sample_time):
            raise ValueError(f"cutoff must be above 0 and below {top:g} Hz, got {self.cutoff}")
        if not 0.0 < self.gamma < 2.0:
            raise ValueError(f"gamma must be in (0, 2), got {self.gamma}")
        if not (np.isfinite(self.regularisation) and self.regularisation > 0.0):
            raise ValueError(f"regularisation must be > 0, got {self.regularisation}")
        weight, size = np.array(self.output_weight), np.array(self.input_size)
        if not ((weight >= 0.0).all() and weight.any()):
            raise ValueError(f"output_weight must be >= 0 and not all 0, got {self.output_weight}")
        if not (size > 0.0).all():
            raise ValueError(f"input_size must be > 0, got {self.input_size}")
        if not self.limit > 0.0:
            raise ValueError(f"limit must be > 0, got {self.limit}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n := len(self.input_size)) != n_columns:
            raise ValueError(f"the law has {n} inputs, the record {n_columns} columns")

    def Q(self, omega: ArrayLike) -> Array:
        """Real, (M,), at omega [rad/sample]."""
        f = np.asarray(omega, dtype=np.float64) / (2.0 * np.pi * self.sample_time)
        return 1.0 / (1.0 + (f / self.cutoff) ** self.sharpness)

    def L(self, omega: ArrayLike) -> Complex:
        """(M, n, p) at omega (M,) [rad/sample]."""
        weight, size = np.array(self.output_weight), np.array(self.input_size)

        def scaled(at: ArrayLike) -> Complex:
            return weight[:, None] * self.G.response(at) * size

        T = scaled(omega)
        rho = self.regularisation * np.linalg.norm(scaled(np.zeros(1))[0], ord=2) ** 2
        T_H = np.conj(np.swapaxes(T, 1, 2))
        inverse = np.linalg.solve(T_H @ T + rho * np.eye(len(size)), T_H)
        return np.asarray(size[:, None] * inverse * weight, dtype=np.complex128)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        n_samples = len(correction)
        omega = 2.0 * np.pi * np.fft.rfftfreq(2 * n_samples)
        E, U = (np.fft.rfft(tapered(signal), axis=0) for signal in (error, correction))
        learned = U + self.gamma * (self.L(omega) @ E[:, :, None])[:, :, 0]
        u = np.fft.irfft(self.Q(omega)[:, None] * learned, 2 * n_samples, axis=0)[:n_samples]
        largest = self.limit * np.array(self.input_size)
        return np.clip(u, -largest, largest)

    def contraction(self, omega: ArrayLike, plant: Response) -> Array:
        """(M,): largest singular value of Q (1 - gamma L G) on a plant, inputs in their size.

        Below 1 at each frequency the correction converges monotonically.
        """
        size = np.array(self.input_size)
        LG = self.L(omega) @ plant.response(omega)
        moved = np.eye(len(size)) - self.gamma * LG / size[:, None] * size
        return self.Q(omega) * np.linalg.norm(moved, ord=2, axis=(1, 2))


@records("signal")
def tapered(signal: Array) -> Array:
    """Record (N, n) followed by a taper from its last value to its first: (2 N, n), periodic."""
    n = len(signal)
    fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, n + 1) / (n + 1))
    return np.concatenate((signal, signal[0] + np.outer(fade, signal[-1] - signal[0])))
