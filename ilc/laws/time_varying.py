"""Filters that vary along the trajectory, for `FirstOrder`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.system import Complex
from ..records import as_real, records


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
