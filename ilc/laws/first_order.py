"""Interface of a learning law, the general first-order law u_{k+1} = Q(u_k + L e_k), and learning
filters L without a model: shifted gain (P-type), derivative (D-type), gain matrix, blend.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter, check_shift, shift
from ..models.system import Complex, unit_circle
from ..records import as_real, as_whole, records


class Law(Protocol):
    """Learning law: (u_k, e_k, memory) to (u_{k+1}, memory). It holds design variables only."""

    def step(self, correction: Array, error: Array, memory: Any = None, /) -> tuple[Array, Any]:
        """u_{k+1} and the next memory from u_k, e_k, shape (N, n), and the memory (first: None)."""
        ...

    def check(self, n_samples: int, n_columns: int) -> None:
        """Raise ValueError if the law does not fit records of shape (N, n)."""
        ...


class FirstOrderLaw:
    """Base of laws without memory: `__call__(u_k, e_k)` returns u_{k+1}."""

    def __call__(self, correction: Array, error: Array, /) -> Array:
        raise NotImplementedError

    @records("correction", "error", alike=False)
    def step(self, correction: Array, error: Array, memory: None = None, /) -> tuple[Array, None]:
        return self(correction, error), None

    def check(self, n_samples: int, n_columns: int) -> None:
        """Accept records of every shape, unless a law overrides this."""


@dataclass(frozen=True, kw_only=True)
class FilteredLaw:
    """Filters of a law: L of the error, an inverse of T_u or an approximation, and Q."""

    L: RecordFilter
    Q: RecordFilter = ALL_PASS

    def check(self, n_samples: int, n_columns: int) -> None:
        """Raise ValueError if a filter does not fit records of shape (N, n)."""
        self.L.check(n_samples, n_columns)
        self.Q.check(n_samples, n_columns)


@dataclass(frozen=True, kw_only=True)
class FirstOrder(FilteredLaw, FirstOrderLaw):
    """u_{k+1} = Q(u_k + L e_k). Thesis (7.2)."""

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        learned = self.L(error)
        if learned.shape != correction.shape:
            shapes = f"{learned.shape} and {correction.shape}"
            raise ValueError(f"L e and the correction must have one shape, got {shapes}")
        return self.Q(correction + learned)


@dataclass(frozen=True, kw_only=True)
class PType:
    """L = gamma q^delta, the same for all columns; `Heuristic` has one for each motor."""

    gamma: float = 0.9
    delta: int = 0

    def __post_init__(self) -> None:
        if not np.isfinite(self.gamma):
            raise ValueError(f"gamma must be finite, got {self.gamma}")
        as_whole(self.delta, "delta")

    def check(self, n_samples: int, n_columns: int) -> None:
        check_shift(self.delta, n_samples)

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        return self.gamma * shift(signal, self.delta)

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
        change = shift(signal, self.delta) - shift(signal, self.delta - 1)
        return self.gamma_d / self.sample_time * change

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
        return shift(signal, self.delta) @ self.gamma.T

    def response(self, omega: ArrayLike) -> Complex:
        """Shape (M, n, n)."""
        deltas = np.broadcast_to(self.delta, len(self.gamma))
        return self.gamma * unit_circle(np.multiply.outer(omega, deltas))[:, None, :]


@dataclass(frozen=True, kw_only=True, eq=False)
class Blend:
    """sum_m w_m(t) F_m: filters with time-varying weights.

    For a gain or a cutoff that varies along the trajectory. Such a filter has no frequency
    response; the lifted analysis handles it.
    """

    filters: tuple[RecordFilter, ...]
    weights: Array
    """(N, m); for a Q they should be >= 0 with sum at most 1."""

    def __post_init__(self) -> None:
        weights = as_real(self.weights, "weights")
        m = len(self.filters)
        if weights.ndim != 2 or weights.shape[1] != m:
            raise ValueError(f"weights must have shape (N, {m}), got {weights.shape}")
        if not np.isfinite(weights).all():
            raise ValueError("weights must be finite")
        object.__setattr__(self, "weights", weights)

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.weights) != n_samples:
            raise ValueError(f"weights cover {len(self.weights)} samples, the record {n_samples}")
        for one in self.filters:
            one.check(n_samples, n_columns)

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        parts = zip(self.weights.T, self.filters, strict=True)
        return sum((w[:, None] * one(signal) for w, one in parts), np.zeros_like(signal))

    def response(self, omega: ArrayLike) -> Complex:
        raise ValueError("a filter that varies along the trajectory has no frequency response")
