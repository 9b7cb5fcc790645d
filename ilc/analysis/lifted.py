"""Lifted (matrix) form of the iteration on a finite record, edges of its filters included.

A record (N, n) is one vector of N n numbers, sample by sample, motors within a sample. A
time-invariant T_u is lower block-triangular Toeplitz, a law a pair of matrices. For up to a few
thousand numbers.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..laws.law import FirstOrderLaw, require_linear
from ..models.products import Products, require_moderate
from ..models.products import largest_singular_value as of_products
from ..models.state_space import StateSpace
from ..models.system import System
from ..models.system_matrix import AnyModel, SystemMatrix, check_inputs
from ..records import records

_LINEAR = 1e-6  # relative size of what superposition may miss by rounding


def lifted_system(T_u: AnyModel, n_samples: int, n_columns: int = 1) -> Array:
    """T with y = T u, shape (N p, N m), m = n_columns inputs; p = m for one system."""
    check_inputs(T_u, n_columns)
    n_outputs = _outputs(T_u, n_columns)
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


def _outputs(T_u: AnyModel, n_columns: int) -> int:
    return n_columns if isinstance(T_u, System) else T_u.n_outputs


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
        return cls(T, *lifted_law(law, n_samples, n_columns, _outputs(T_u, n_columns)))

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
            [largest_singular_value(self.iteration, int(k)) for k in np.atleast_1d(iterations)]
        )


def largest_singular_value(matrix: Array, power: int) -> float:
    """Of matrix^power, by Lanczos iterations on products with the matrix and its transpose.

    From below: the residual of the vector found is below 1e-10 of the value, so a singular value
    lies that close; the random start makes it the largest one.
    """
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
    return of_products(once, power=power)
