"""Iteration of a first-order law on a finite record, edges of its filters included.

`LiftedIteration` has matrices, for up to a few thousand numbers: a record (N, n) is one vector of
N n numbers, sample by sample, motors within a sample; a time-invariant T_u is lower
block-triangular Toeplitz, a law a pair of matrices. `RecordIteration` is matrix-free: u_{k+1} -
u_inf = A (u_k - u_inf) with A = M_u - M_e T, and each figure takes products with A and its
adjoint alone, O(N) each, so that records of thousands of samples take less than a second.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..laws.first_order import FirstOrderLaw, require_linear
from ..models.products import SMALL, Products, largest_singular_value, require_moderate
from ..models.state_space import StateSpace
from ..models.system import System
from ..models.system_matrix import AnyModel, SystemMatrix, check_inputs, n_outputs_of
from ..records import records
from .adjoint import law_adjoint

_LINEAR = 1e-6  # relative size of what superposition may miss by rounding


def lifted_system(T_u: AnyModel, n_samples: int, n_columns: int = 1) -> Array:
    """T with y = T u, shape (N p, N m), m = n_columns inputs; p = m for one system."""
    check_inputs(T_u, n_columns)
    n_outputs = n_outputs_of(T_u, n_columns)
    if not isinstance(T_u, System | SystemMatrix | StateSpace):
        shapes = (n_samples, n_columns), (n_samples, n_outputs)
        return Products(*shapes, T_u.simulate, T_u.adjoint).dense()
    T = np.zeros((n_samples * n_outputs, n_samples * n_columns))
    for j in range(n_columns):
        start = np.zeros((n_samples, n_columns))
        start[0, j] = 1.0
        impulse = T_u.simulate(start).ravel()
        for t in range(n_samples):
            T[t * n_outputs :, t * n_columns + j] = impulse[: len(T) - t * n_outputs]
    return T


def lifted_law(
    law: FirstOrderLaw, n_samples: int, n_columns: int = 1, n_outputs: int | None = None
) -> tuple[Array, Array]:
    """(M_u, M_e) with u_{k+1} = M_u u_k + M_e e_k, from the law's response to unit vectors.

    n_outputs: columns of an error, n_columns if None. Raises ValueError for a law that is not
    linear.
    """
    require_linear(law)
    inputs = n_samples, n_columns
    outputs = n_samples, n_columns if n_outputs is None else n_outputs
    no_u, no_e = np.zeros(inputs), np.zeros(outputs)
    M_u = np.stack([law(unit, no_e).ravel() for unit in _units(inputs)], axis=1)
    M_e = np.stack([law(no_u, unit).ravel() for unit in _units(outputs)], axis=1)
    rng = np.random.default_rng(0)
    u, e = rng.standard_normal(inputs), rng.standard_normal(outputs)
    together = law(u, e).ravel()
    missed = np.abs(together - M_u @ u.ravel() - M_e @ e.ravel()).max()
    if not missed <= _LINEAR * max(np.abs(together).max(), np.abs(M_u).max(), np.abs(M_e).max()):
        raise ValueError(f"{type(law).__name__} is not linear: its iteration has no matrix")
    return M_u, M_e


def _units(shape: tuple[int, int]) -> Array:
    size = int(np.prod(shape))
    return np.eye(size).reshape(size, *shape)


@dataclass(frozen=True, eq=False)
class LiftedIteration:
    """u_{k+1} = iteration u_k + M_e e_0."""

    T: Array
    """T_u, shape (N p, N m)."""
    M_u: Array
    M_e: Array

    @classmethod
    def build(
        cls, T_u: AnyModel, law: FirstOrderLaw, n_samples: int, n_columns: int = 1
    ) -> "LiftedIteration":
        """From a model with n_columns inputs. Raises ValueError for a law that does not fit, has
        memory, has limits or is not linear."""
        law.check(n_samples, n_columns)
        T = lifted_system(T_u, n_samples, n_columns)
        return cls(T, *lifted_law(law, n_samples, n_columns, n_outputs_of(T_u, n_columns)))

    @cached_property
    def iteration(self) -> Array:
        """M_u - M_e T: maps the distance from the fixed point over one iteration."""
        return self.M_u - self.M_e @ self.T

    @property
    def spectral_radius(self) -> float:
        """Spectral radius; below 1 the iteration converges, perhaps after a long transient."""
        return float(np.abs(np.linalg.eigvals(self.iteration)).max())

    @property
    def contraction(self) -> float:
        """Largest singular value. Below 1: ||u_k - u_inf|| shrinks in every iteration."""
        return _largest_of_power(self.iteration, 1)

    @records("first_error")
    def fixed_point(self, first_error: Array) -> tuple[Array, Array]:
        """(u_inf, e_inf), (N, m) and (N, p), from e_0 with u = 0. ValueError if none exists."""
        matrix = np.eye(len(self.iteration)) - self.iteration
        e_0 = np.asarray(first_error).ravel()
        try:
            u: Array = np.linalg.solve(matrix, self.M_e @ e_0).astype(np.float64)
        except np.linalg.LinAlgError as error:
            raise ValueError("the iteration has no fixed point: it has an eigenvalue 1") from error
        shape = np.shape(first_error)
        return u.reshape(len(first_error), -1), (e_0 - self.T @ u).reshape(shape)

    def transient_growth(self, iterations: ArrayLike) -> Array:
        """||iteration^k||_2 at the given k: the growth of a transient."""
        return np.array(
            [_largest_of_power(self.iteration, int(k)) for k in np.atleast_1d(iterations)]
        )


def _largest_of_power(matrix: Array, power: int) -> float:
    """2-norm of matrix^power, see `largest_singular_value`."""
    size = len(matrix)
    if power == 0:
        return 1.0
    if 20 * power > size * np.log2(power + 1):  # cheaper by repeated squaring first
        with np.errstate(over="ignore", invalid="ignore"):
            raised = np.linalg.matrix_power(matrix, power)
        require_moderate(raised, power)
        matrix, power = raised, 1
    record = size, 1
    once = Products(record, record, lambda v: matrix @ v, lambda v: matrix.T @ v)
    return largest_singular_value(once, power=power)


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
        n_outputs = n_outputs_of(self.T_u, self.n_columns)
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
        operator, krylov = self.products.operator(), min(size, 40)
        try:
            return solve(operator, k=1, ncv=krylov, tol=1e-9, v0=start, maxiter=_RESTARTS)
        except ArpackError:
            return None
