"""Iteration of a first-order law on a finite record as a matrix, edges of its filters included.

A record (N, n) is one vector of N n numbers, sample by sample, motors within a sample; up to a few
thousand numbers. A time-invariant T_u is lower block-triangular Toeplitz, a law a pair of matrices.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..laws.first_order import FirstOrderLaw
from ..models.products import dense
from ..models.state_space import StateSpace
from ..models.system import System
from ..models.system_matrix import AnyModel, SystemMatrix, check_inputs, n_outputs_of
from ..records import records

_LINEAR = 1e-6  # relative size of what superposition may miss by rounding
_LARGEST = 1e150  # of a power, whose square is a number


def lifted_system(T_u: AnyModel, n_samples: int, n_columns: int = 1) -> Array:
    """T with y = T u, shape (N p, N m), m = n_columns inputs; p = m for one system."""
    check_inputs(T_u, n_columns)
    n_outputs = n_outputs_of(T_u, n_columns)
    if not isinstance(T_u, System | SystemMatrix | StateSpace):
        return dense(T_u, n_samples)
    T = np.zeros((n_samples * n_outputs, n_samples * n_columns))
    for j in range(n_columns):
        start = np.zeros((n_samples, n_columns))
        start[0, j] = 1.0
        impulse = T_u.simulate(start).ravel()
        for t in range(n_samples):
            T[t * n_outputs :, t * n_columns + j] = impulse[: len(T) - t * n_outputs]
    return T


def lifted_law(
    law: FirstOrderLaw, n_samples: int, n_columns: int, n_outputs: int
) -> tuple[Array, Array]:
    """(M_u, M_e) with u_{k+1} = M_u u_k + M_e e_k, from the law's response to unit vectors.

    n_outputs: columns of an error. Raises ValueError for a law that is not linear.
    """
    name = type(law).__name__
    if not callable(law):
        raise ValueError(f"{name} has a memory: the analysis is that of laws without one")
    if np.isfinite(getattr(law, "limit", np.inf)).any():
        raise ValueError(f"{name} has limits, so it is not linear: analyse it with limit=inf")
    inputs, outputs = (n_samples, n_columns), (n_samples, n_outputs)
    no_u, no_e = np.zeros(inputs), np.zeros(outputs)
    M_u = np.stack([law(unit, no_e).ravel() for unit in _units(inputs)], axis=1)
    M_e = np.stack([law(no_u, unit).ravel() for unit in _units(outputs)], axis=1)
    rng = np.random.default_rng(0)
    u, e = rng.standard_normal(inputs), rng.standard_normal(outputs)
    together = law(u, e).ravel()
    missed = np.abs(together - M_u @ u.ravel() - M_e @ e.ravel()).max()
    if not missed <= _LINEAR * max(np.abs(together).max(), np.abs(M_u).max(), np.abs(M_e).max()):
        raise ValueError(f"{name} is not linear: its iteration has no matrix")
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
        return float(np.linalg.norm(self.iteration, ord=2))

    @records("first_error")
    def fixed_point(self, first_error: Array) -> tuple[Array, Array]:
        """(u_inf, e_inf), (N, m) and (N, p), from e_0 with u = 0. ValueError if none exists."""
        matrix = np.eye(len(self.iteration)) - self.iteration
        e_0 = first_error.ravel()
        try:
            u: Array = np.linalg.solve(matrix, self.M_e @ e_0).astype(np.float64)
        except np.linalg.LinAlgError as error:
            raise ValueError("the iteration has no fixed point: it has an eigenvalue 1") from error
        return u.reshape(len(first_error), -1), (e_0 - self.T @ u).reshape(first_error.shape)

    def transient_growth(self, iterations: ArrayLike) -> Array:
        """||iteration^k||_2 at the given k: the growth of a transient. OverflowError for a power
        beyond 1e150."""
        found = []
        for k in np.atleast_1d(iterations).tolist():
            with np.errstate(over="ignore", invalid="ignore"):
                power = np.linalg.matrix_power(self.iteration, int(k))
            if not np.abs(power).max() < _LARGEST:
                raise OverflowError(f"power {k} of the map exceeds {_LARGEST:g}: it diverges")
            found.append(np.linalg.norm(power, ord=2))
        return np.array(found)
