"""Gradients measured on the plant itself, without a model, at the cost of further runs."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from .law import FirstOrderLaw

Experiment = Callable[[Array], Array]
"""Runs a correction (N, n) and returns the output (N, n)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredGradient(FirstOrderLaw):
    """u_{k+1} = Q(u_k + step T^T e_k), T^T e_k measured by time reversal.

    For a linear, time-invariant plant T^T e is the time-reversed response to the time-reversed
    error, so it can be measured as the difference of two outputs. The step is the one that
    minimises ||e_{k+1}|| along the gradient, found with one run more.
    """

    experiment: Experiment
    coupled: bool = False
    """True: motors disturb each other; then n^2 runs measure the gradient instead of one."""
    size: float = 1.0
    """Peak of a test correction relative to that of the error: large against noise, small
    against nonlinearity."""
    Q: RecordFilter = ALL_PASS

    def __post_init__(self) -> None:
        if not (np.isfinite(self.size) and self.size > 0.0):
            raise ValueError(f"size must be > 0, got {self.size}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.Q.check(n_samples, n_columns)

    def __call__(self, correction: Array, error: Array, /) -> Array:
        if not error.any():
            return self.Q(correction)
        base = self.experiment(correction)

        def response(direction: Array) -> Array:
            """T d, scaled to a test of the wanted size."""
            scale = self.size * np.abs(error).max() / np.abs(direction).max()
            return (self.experiment(correction + scale * direction) - base) / scale

        gradient = self._gradient(response, error)
        if not gradient.any():
            return self.Q(correction)
        seen = response(gradient)
        step = float((seen * error).sum() / np.square(seen).sum()) if seen.any() else 0.0
        return self.Q(correction + step * gradient)

    def _gradient(self, response: Experiment, error: Array) -> Array:
        reversed_error = error[::-1]
        if not self.coupled:
            return response(reversed_error)[::-1]
        n = error.shape[1]
        gradient = np.zeros_like(error)
        for j in range(n):  # input j: (T^T e)_j = sum_i of the reversed T_ij of reversed e_i
            for i in range(n):
                if not error[:, i].any():
                    continue
                test = np.zeros_like(error)
                test[:, j] = reversed_error[:, i]
                gradient[:, j] += response(test)[::-1, i]
        return gradient
