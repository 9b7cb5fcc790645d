"""Iteration of a first-order law on a finite record, matrix-free: convergence and its transient.

u_{k+1} - u_inf = A (u_k - u_inf) with A = M_u - M_e T. Each figure takes products with A and its
adjoint alone, O(N) each, so that records of thousands of samples take less than a second.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..laws.law import FirstOrderLaw, require_linear
from ..models.products import SMALL, Products, largest_singular_value
from ..models.system import System
from ..models.system_matrix import AnyModel, check_inputs
from .adjoint import law_adjoint

_POWERS = (8, 32)  # iterations whose growth bounds the spectral radius
_ROUGH = 1e-4  # of that growth, whose root is taken
_FEWEST = 3  # numbers of a record for Arnoldi iterations
_RESTARTS = 20  # of Arnoldi iterations, after which no eigenvalue is stated


@dataclass(frozen=True, eq=False)
class SpectralRadius:
    """Of an iteration: below 1 it converges, perhaps after a long transient."""

    eigenvalue: complex | None
    """The largest by modulus that Arnoldi iterations found; None: none converged."""
    residual: float | None
    """|A v - lambda v| / |v|: lambda is exact for a matrix that differs from A by so much."""
    bound: float
    """||A^k||_2^(1/k), an upper bound, k = 8 or 32: the first for which it is below 1."""

    @property
    def value(self) -> float | None:
        """Modulus of the eigenvalue."""
        return None if self.eigenvalue is None else abs(self.eigenvalue)


@dataclass(frozen=True, eq=False)
class RecordIteration:
    """Law without memory and plant on records (N, n)."""

    T_u: AnyModel
    law: FirstOrderLaw
    n_samples: int
    n_columns: int = 1

    def __post_init__(self) -> None:
        require_linear(self.law)
        check_inputs(self.T_u, self.n_columns)
        self.law.check(self.n_samples, self.n_columns)

    def _forward(self, u: Array) -> Array:
        return self.law(u, -self.T_u.simulate(u))

    def _backward(self, v: Array) -> Array:
        back_u, back_e = law_adjoint(self.law, v)
        return back_u - self.T_u.adjoint(back_e)

    @property
    def products(self) -> Products:
        """A and its adjoint."""
        shape = self.n_samples, self.n_columns
        return Products(shape, shape, self._forward, self._backward)

    @property
    def contraction(self) -> float:
        """||A||_2. Below 1: ||u_k - u_inf|| shrinks in every iteration."""
        return largest_singular_value(self.products)

    @property
    def error_contraction(self) -> float:
        """||1 - T M_e||_2. Below 1: ||e_k - e_inf|| shrinks in every iteration, for laws with
        M_u = 1 (Q = 1).

        Raises ValueError for other laws: with Q the next error does not follow from the error.
        """
        n_outputs = self.n_columns if isinstance(self.T_u, System) else self.T_u.n_outputs
        inputs, outputs = (self.n_samples, self.n_columns), (self.n_samples, n_outputs)
        probe = np.random.default_rng(0).standard_normal(inputs)
        if np.abs(self.law(probe, np.zeros(outputs)) - probe).max() > 1e-12 * np.abs(probe).max():
            raise ValueError(
                "with Q the next error does not follow from the error alone: see `contraction`"
            )
        none = np.zeros(inputs)

        def forward(e: Array) -> Array:
            return e - self.T_u.simulate(self.law(none, e))

        def backward(e: Array) -> Array:
            return e - law_adjoint(self.law, self.T_u.adjoint(e))[1]

        return largest_singular_value(Products(outputs, outputs, forward, backward))

    def transient_growth(self, iterations: ArrayLike) -> Array:
        """||A^k||_2 at the given k: the largest growth of ||u_k - u_inf|| over k iterations."""
        counts = np.atleast_1d(iterations).tolist()
        return np.array([largest_singular_value(self.products, power=int(k)) for k in counts])

    @property
    def spectral_radius(self) -> SpectralRadius:
        """By Arnoldi iterations, with a bound from above."""
        eigenvalue, residual = self._largest_eigenvalue()
        bound = np.inf
        for k in _POWERS:
            try:
                growth = largest_singular_value(self.products, _ROUGH, k)
            except (RuntimeError, OverflowError):  # lost: the bound of fewer iterations remains
                break
            bound = min(bound, ((1.0 + 10.0 * _ROUGH) * growth) ** (1.0 / k))
            if bound < 1.0 or (eigenvalue is not None and abs(eigenvalue) >= 1.0):
                break
        return SpectralRadius(eigenvalue, residual, bound)

    def _largest_eigenvalue(self) -> tuple[complex | None, float | None]:
        products, size = self.products, self.n_samples * self.n_columns
        found = self._by_arnoldi() if size >= _FEWEST else None
        if found is None:
            if size > SMALL:
                return None, None
            found = np.linalg.eig(products.dense())
        values, vectors = found
        largest = int(np.abs(values).argmax())
        v: Any = vectors[:, largest]
        Av = sum(
            factor * self._forward(part.reshape(products.inputs)).ravel()
            for factor, part in ((1.0, v.real), (1j, v.imag))
        )
        return complex(values[largest]), float(np.linalg.norm(Av - values[largest] * v))

    def _by_arnoldi(self) -> tuple[Any, Any] | None:
        """Eigenvalue of the largest modulus and its vector; None: not converged, or nilpotent."""
        from scipy.sparse.linalg import ArpackError, eigs

        size = self.n_samples * self.n_columns
        solve: Any = eigs  # its stubs know no tolerance that is a float
        start = np.random.default_rng(0).standard_normal(size)
        options = {"ncv": min(size, 40), "tol": 1e-9, "v0": start, "maxiter": _RESTARTS}
        try:
            return solve(self.products.operator(), k=1, **options)
        except ArpackError:
            return None
