"""Backtracking around a law: back to the best iteration, with a smaller gain, when errors grow."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..records import records
from .law import FirstOrderLaw


class Best(NamedTuple):
    """Best iteration so far, and the step length from it."""

    correction: Array
    error: Array
    size: float
    gain: float
    setbacks: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Guarded:
    """Law with backtracking: a step is kept only if the error does not grow.

    After an error above `tolerance` times the smallest, the next iteration starts from the best
    correction with `back_off` times the last step; after `patience` of these it is repeated.
    """

    law: FirstOrderLaw
    weight: tuple[float, ...]
    """(p,), weights of the error's columns in its size; 0 leaves one out."""
    tolerance: float = 1.2
    """Above 1, so that measurement noise is not taken for growth."""
    back_off: float = 0.5
    patience: int = 3

    def __post_init__(self) -> None:
        if not self.tolerance >= 1.0:
            raise ValueError(f"tolerance must be >= 1, got {self.tolerance}")
        if not 0.0 < self.back_off < 1.0:
            raise ValueError(f"back_off must be in (0, 1), got {self.back_off}")
        if self.patience < 1:
            raise ValueError(f"patience must be >= 1, got {self.patience}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.law.check(n_samples, n_columns)

    @records("error")
    def size(self, error: Array) -> float:
        """Weighted RMS of an error."""
        return float(np.sqrt(np.square(error * np.array(self.weight)).sum(axis=1).mean()))

    @records("correction", "error", alike=False)
    def step(
        self, correction: Array, error: Array, memory: Best | None = None, /
    ) -> tuple[Array, Best]:
        size = self.size(error)
        if memory is None:
            memory = Best(correction, error, size, 1.0, 0)
        elif size <= memory.size:
            memory = Best(correction, error, size, memory.gain, memory.setbacks)
        elif size > self.tolerance * memory.size:
            memory = memory._replace(gain=memory.gain * self.back_off, setbacks=memory.setbacks + 1)
            correction, error = memory.correction, memory.error
        if memory.setbacks >= self.patience:
            return memory.correction, memory
        wanted = self.law(correction, error)
        return correction + memory.gain * (wanted - correction), memory
