"""Laws that measure responses of the plant by further runs: its gradient, or its Jacobian."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from ..records import as_real, records
from .first_order import FirstOrderLaw

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


@dataclass(frozen=True, kw_only=True, eq=False)
class FiniteDifference(FirstOrderLaw):
    """Gauss-Newton step with a Jacobian measured by one run a basis correction and motor.

    u_{k+1} = u_k + B c, where c solves min ||e_k - J c||^2 + damping ||c||^2 and column m of J
    is the measured response to basis correction m.
    """

    experiment: PlantRun
    basis: Array
    """(N, m): corrections of one motor that may be combined, such as B-splines; each motor
    gets its own m coefficients."""
    size: float = 1e-3
    """Coefficient of a basis correction in a test run."""
    damping: float = 1e-9
    """Relative to the largest column of J, squared."""

    def __post_init__(self) -> None:
        basis = as_real(self.basis, "basis")
        if basis.ndim != 2 or not basis.any(axis=0).all():
            needed = "shape (N, m) without empty columns"
            raise ValueError(f"basis must have {needed}, got {basis.shape}")
        for name in ("size", "damping"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.basis) != n_samples:
            raise ValueError(f"basis has {len(self.basis)} samples, the record {n_samples}")

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        base = self.experiment(correction)
        n_columns, n_basis = error.shape[1], self.basis.shape[1]
        J = np.empty((error.size, n_columns * n_basis))
        for j in range(n_columns):
            for m in range(n_basis):
                test = correction.copy()
                test[:, j] += self.size * self.basis[:, m]
                J[:, j * n_basis + m] = (self.experiment(test) - base).ravel() / self.size
        rho = self.damping * np.square(J).sum(axis=0).max()
        c = np.linalg.solve(J.T @ J + rho * np.eye(J.shape[1]), J.T @ error.ravel())
        return correction + self.basis @ c.reshape(n_columns, n_basis).T


def b_splines(n_samples: int, n_basis: int) -> Array:
    """(N, m) B-splines with evenly spaced knots over the record, for `FiniteDifference`."""
    from scipy.interpolate import BSpline

    degree = 3
    if n_basis <= degree or n_samples < n_basis:
        raise ValueError(f"n_basis must be in {degree + 1}..{n_samples}, got {n_basis}")
    inner = np.linspace(0.0, 1.0, n_basis - degree + 1)
    knots = np.concatenate((np.zeros(degree), inner, np.ones(degree)))
    return BSpline.design_matrix(np.linspace(0.0, 1.0, n_samples), knots, degree).toarray()
