"""A law over a record of several segments, each of which ends its learning when it has converged.

A segment whose error falls by less than `least` in `patience` updates running keeps the correction
of its best iteration, while the others learn on. Segments are blended where one follows the other.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..records import records
from .law import Law


class SegmentMemory(NamedTuple):
    """State of the segments before an update."""

    inner: Any
    """Memory of the law."""
    best: Array
    """(N, n), correction of each segment's best iteration."""
    size: Array
    """(M,) size of the error of that iteration."""
    stalls: NDArray[np.int64]
    """(M,) updates running that brought little."""
    held: NDArray[np.bool_]
    """(M,) bool: the segment has converged and keeps its best correction."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BySegment:
    """Law for records of M segments."""

    law: Law
    weight: Array = field(repr=False)
    """(N, M), of each segment in the correction at each sample; rows sum to 1."""
    judged: tuple[tuple[int, int], ...]
    """(M,) first sample and the one after the last, by whose error a segment is judged."""
    size_of: Callable[[Array], Array]
    """Sizes of an error (K, p)."""
    least: float = 0.1
    patience: int = 2

    def __post_init__(self) -> None:
        if not 0.0 < self.least < 1.0:
            raise ValueError(f"least must be between 0 and 1, got {self.least}")
        if self.patience < 1:
            raise ValueError(f"patience must be >= 1, got {self.patience}")
        if self.weight.ndim != 2 or self.weight.shape[1] != len(self.judged):
            raise ValueError(f"weight must be (N, {len(self.judged)}), got {self.weight.shape}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.weight) != n_samples:
            raise ValueError(f"weight must have {n_samples} rows, got {len(self.weight)}")
        self.law.check(n_samples, n_columns)

    def _sizes(self, error: Array) -> Array:
        """(M,) size of an error (N, p) in each segment."""
        own = (self.size_of(error[first:last]) for first, last in self.judged)
        return np.array([float(np.linalg.norm(size)) for size in own])

    @records("correction", "error", alike=False)
    def step(
        self, correction: Array, error: Array, memory: SegmentMemory | None = None, /
    ) -> tuple[Array, SegmentMemory]:
        seen = self._seen(correction, self._sizes(error), memory)
        wanted, inner = self.law.step(correction, error, seen.inner)
        kept = (self.weight @ seen.held.astype(np.float64))[:, np.newaxis]
        return wanted + kept * (seen.best - wanted), seen._replace(inner=inner)

    def _seen(self, u: Array, size: Array, memory: SegmentMemory | None) -> SegmentMemory:
        """The memory with one more run in it."""
        if memory is None:
            none = np.zeros(len(size), dtype=np.int64)
            return SegmentMemory(None, u, size, none, none.astype(bool))
        stalls = np.where(size > (1.0 - self.least) * memory.size, memory.stalls + 1, 0)
        better = (size < memory.size) & ~memory.held
        moved = (self.weight @ better.astype(np.float64))[:, np.newaxis]
        return SegmentMemory(
            inner=memory.inner,
            best=memory.best + moved * (u - memory.best),
            size=np.where(better, size, memory.size),
            stalls=np.where(memory.held, memory.stalls, stalls),
            held=memory.held | (stalls >= self.patience),
        )
