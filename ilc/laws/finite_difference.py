"""Gauss-Newton on a few basis corrections, with responses measured on the plant."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..records import as_real, records
from .law import FirstOrderLaw
from .model_free import PlantRun


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


def b_splines(n_samples: int, n_basis: int, degree: int = 3) -> Array:
    """(N, m) B-splines with evenly spaced knots over the record, for `FiniteDifference`."""
    from scipy.interpolate import BSpline

    if n_basis <= degree or n_samples < n_basis:
        raise ValueError(f"n_basis must be in {degree + 1}..{n_samples}, got {n_basis}")
    inner = np.linspace(0.0, 1.0, n_basis - degree + 1)
    knots = np.concatenate((np.zeros(degree), inner, np.ones(degree)))
    return BSpline.design_matrix(np.linspace(0.0, 1.0, n_samples), knots, degree).toarray()
