"""Gradient descent without a model: the gradient is measured by further runs of the plant."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from ..records import records
from .law import FirstOrderLaw

PlantRun = Callable[[Array], Array]
"""Run of the plant: correction (N, n) in, output (N, n) back."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredGradient(FirstOrderLaw):
    """u_{k+1} = Q(u_k + step T^T e_k), T^T e_k measured by time reversal.

    For a linear, time-invariant plant T^T e is the time-reversed response to the time-reversed
    error, the difference of two outputs. The step minimises ||e_{k+1}|| along the gradient and
    needs one more run.
    """

    experiment: PlantRun
    coupled: bool = False
    """True for coupled motors: n^2 runs measure the gradient instead of one."""
    size: float = 1.0
    """Peak of a test correction relative to that of the error: large against noise, small
    against nonlinearity."""
    Q: RecordFilter = ALL_PASS

    def __post_init__(self) -> None:
        if not (np.isfinite(self.size) and self.size > 0.0):
            raise ValueError(f"size must be > 0, got {self.size}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.Q.check(n_samples, n_columns)

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        if not error.any():
            return self.Q(correction)
        base = self.experiment(correction)

        def response(direction: Array) -> Array:
            """T d, measured with a test correction of the configured size."""
            scale = self.size * np.abs(error).max() / np.abs(direction).max()
            return (self.experiment(correction + scale * direction) - base) / scale

        gradient = self._gradient(response, error)
        if not gradient.any():
            return self.Q(correction)
        seen = response(gradient)
        step = float((seen * error).sum() / np.square(seen).sum()) if seen.any() else 0.0
        return self.Q(correction + step * gradient)

    def _gradient(self, response: PlantRun, error: Array) -> Array:
        reversed_error = error[::-1]
        if not self.coupled:
            return response(reversed_error)[::-1]
        n = error.shape[1]
        gradient = np.zeros_like(error)
        for j in range(n):  # input j: (T^T e)_j = sum_i of the reversed T_ij of reversed e_i
            for i in np.flatnonzero(error.any(axis=0)):
                test = np.zeros_like(error)
                test[:, j] = reversed_error[:, i]
                gradient[:, j] += response(test)[::-1, i]
        return gradient
