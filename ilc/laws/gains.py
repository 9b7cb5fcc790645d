"""Learning filters L without a model: shifted gain (P-type), derivative (D-type), gain matrix."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import End, check_shift, shift
from ..models.system import Complex, unit_circle
from ..records import as_real, as_whole, records


@dataclass(frozen=True, kw_only=True)
class PType:
    """L = gamma q^delta, the same for all columns; `Heuristic` has one for each motor."""

    gamma: float = 0.9
    delta: int = 0
    end: End = End.HOLD

    def __post_init__(self) -> None:
        if not np.isfinite(self.gamma):
            raise ValueError(f"gamma must be finite, got {self.gamma}")
        as_whole(self.delta, "delta")

    def check(self, n_samples: int, n_columns: int) -> None:
        check_shift(self.delta, n_samples)

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        return self.gamma * shift(signal, self.delta, self.end)

    def response(self, omega: ArrayLike) -> Complex:
        return self.gamma * unit_circle(omega) ** self.delta


@dataclass(frozen=True, kw_only=True)
class DType:
    """L = gamma_d q^delta (1 - q^-1) / T: learning from the derivative of the error. Thesis 7.3.

    After Arimoto et al. (1984), in discrete time; gamma_d and the sample time T are in [s].
    """

    gamma_d: float
    sample_time: float
    delta: int = 1
    """Shift of the newer of the two samples."""
    end: End = End.HOLD

    def __post_init__(self) -> None:
        if not np.isfinite(self.gamma_d):
            raise ValueError(f"gamma_d must be finite, got {self.gamma_d}")
        if not self.sample_time > 0.0:
            raise ValueError(f"sample_time must be > 0 s, got {self.sample_time}")
        as_whole(self.delta, "delta")

    def check(self, n_samples: int, n_columns: int) -> None:
        check_shift(self.delta, n_samples)
        check_shift(self.delta - 1, n_samples)

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        newer = shift(signal, self.delta, self.end)
        older = shift(signal, self.delta - 1, self.end)
        return self.gamma_d / self.sample_time * (newer - older)

    def response(self, omega: ArrayLike) -> Complex:
        q = unit_circle(omega)
        return self.gamma_d / self.sample_time * q**self.delta * (1.0 - 1.0 / q)


@dataclass(frozen=True, kw_only=True, eq=False)
class MatrixGain:
    """L = Gamma q^delta with a gain matrix, for coupled motors."""

    gamma: Array
    """(n, n); entry (i, j) is the gain from the error of motor j to the correction of motor i."""
    delta: int | tuple[int, ...] = 0
    """Shift of each error [samples]."""
    end: End = End.HOLD

    def __post_init__(self) -> None:
        gamma = np.array(as_real(self.gamma, "gamma"))
        if gamma.ndim != 2 or gamma.shape[0] != gamma.shape[1] or not np.isfinite(gamma).all():
            raise ValueError(f"gamma must be a finite (n, n) matrix, got {gamma}")
        as_whole(self.delta, "delta")
        object.__setattr__(self, "gamma", gamma)

    def check(self, n_samples: int, n_columns: int) -> None:
        check_shift(self.delta, n_samples)
        if len(self.gamma) != n_columns:
            raise ValueError(f"gamma must be {n_columns} x {n_columns}, got {self.gamma.shape}")

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        return shift(signal, self.delta, self.end) @ self.gamma.T

    def response(self, omega: ArrayLike) -> Complex:
        """Shape (M, n, n)."""
        deltas = np.broadcast_to(self.delta, len(self.gamma))
        return self.gamma * unit_circle(np.multiply.outer(omega, deltas))[:, None, :]
