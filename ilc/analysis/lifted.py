"""Lifted (matrix) form of the iteration on a finite record, edges of its filters included.

A record (N, n) is one vector of N n numbers, sample by sample, motors within a sample. T_u is
lower block-triangular Toeplitz and a law is a pair of matrices. For up to a few thousand numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..laws.law import FirstOrderLaw
from ..models.system_matrix import Model
from ..records import records


def lifted_system(T_u: Model, n_samples: int, n_columns: int = 1) -> Array:
    """T with y = T u, shape (N n, N n)."""
    size = n_samples * n_columns
    T = np.zeros((size, size))
    for j in range(n_columns):
        start = np.zeros((n_samples, n_columns))
        start[0, j] = 1.0
        impulse = T_u.simulate(start).ravel()
        for t in range(n_samples):
            T[t * n_columns :, t * n_columns + j] = impulse[: size - t * n_columns]
    return T


def lifted_law(law: FirstOrderLaw, n_samples: int, n_columns: int = 1) -> tuple[Array, Array]:
    """(M_u, M_e) with u_{k+1} = M_u u_k + M_e e_k, from the law's response to unit vectors."""
    size = n_samples * n_columns
    zero = np.zeros((n_samples, n_columns))
    units = np.eye(size).reshape(size, n_samples, n_columns)
    M_u = np.stack([law(unit, zero).ravel() for unit in units], axis=1)
    M_e = np.stack([law(zero, unit).ravel() for unit in units], axis=1)
    return M_u, M_e


@dataclass(frozen=True, eq=False)
class LiftedIteration:
    """u_{k+1} = iteration u_k + M_e e_0."""

    T: Array
    """T_u, shape (N n, N n)."""
    M_u: Array
    M_e: Array

    @classmethod
    def build(
        cls, T_u: Model, law: FirstOrderLaw, n_samples: int, n_columns: int = 1
    ) -> "LiftedIteration":
        law.check(n_samples, n_columns)
        return cls(lifted_system(T_u, n_samples, n_columns), *lifted_law(law, n_samples, n_columns))

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
        return largest_singular_value(self.iteration, 1)

    @records("first_error")
    def fixed_point(self, first_error: Array) -> tuple[Array, Array]:
        """(u_inf, e_inf), (N, n) each, from e_0 with u = 0. ValueError if none exists."""
        matrix = np.eye(len(self.T)) - self.iteration
        e_0 = np.asarray(first_error).ravel()
        try:
            u: Array = np.linalg.solve(matrix, self.M_e @ e_0).astype(np.float64)
        except np.linalg.LinAlgError as error:
            raise ValueError("the iteration has no fixed point: it has an eigenvalue 1") from error
        shape = np.shape(first_error)
        return u.reshape(shape), (e_0 - self.T @ u).reshape(shape)

    def transient_growth(self, iterations: ArrayLike) -> Array:
        """||iteration^k||_2 at the given k: the growth of a transient."""
        return np.array(
            [largest_singular_value(self.iteration, int(k)) for k in np.atleast_1d(iterations)]
        )


def largest_singular_value(matrix: Array, power: int) -> float:
    """Of matrix^power, by Lanczos iterations on products with the matrix and its transpose.

    From below: the residual of the vector found is below 1e-10 of the value, so a singular value
    lies that close; the random start makes it the largest one.
    """
    from scipy.sparse.linalg import LinearOperator, svds

    size = len(matrix)
    if size <= 2 or power == 0:  # too small for Lanczos
        return float(np.linalg.norm(np.linalg.matrix_power(matrix, power), ord=2))
    if 20 * power > size * np.log2(power + 1):  # cheaper by repeated squaring first
        matrix, power = np.linalg.matrix_power(matrix, power), 1

    def applied(factor: Array) -> Callable[[Array], Array]:
        def times(vector: Array) -> Array:
            for _ in range(power):
                vector = factor @ vector
            return vector

        return times

    # scipy's stubs know neither the keywords of the operator nor a tolerance that is a float
    build: Any = LinearOperator
    solve: Any = svds
    operator = build(
        matrix.shape, matvec=applied(matrix), rmatvec=applied(matrix.T), dtype=np.float64
    )
    start = np.random.default_rng(0).standard_normal(size)
    found = solve(operator, k=1, tol=1e-10, v0=start, return_singular_vectors=False)
    return float(found[0])
