"""The iteration on a finite record, with the real edges of its filters: plain matrices.

One record is one vector; T_u is lower-triangular Toeplitz, the law is a pair of matrices. For
one motor and records up to a few thousand samples.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..laws.law import FirstOrderLaw
from ..plant import Array
from ..system import System


def lifted_system(T_u: System, n_samples: int) -> Array:
    """T with y = T u, shape (N, N)."""
    from scipy.linalg import toeplitz

    return toeplitz(T_u.impulse(n_samples), np.zeros(n_samples))


def lifted_law(law: FirstOrderLaw, n_samples: int) -> tuple[Array, Array]:
    """(M_u, M_e) with u_{k+1} = M_u u_k + M_e e_k, whatever the law does at its edges.

    Column by column, as one motor: what the law makes of a one at each sample.
    """
    zero = np.zeros((n_samples, 1))
    units = np.eye(n_samples)[:, :, None]
    M_u = np.concatenate([law(unit, zero) for unit in units], axis=1)
    M_e = np.concatenate([law(zero, unit) for unit in units], axis=1)
    return M_u, M_e


@dataclass(frozen=True, eq=False)
class LiftedIteration:
    """u_{k+1} = iteration u_k + M_e e_0."""

    T: Array
    """T_u, shape (N, N)."""
    M_u: Array
    M_e: Array

    @classmethod
    def build(cls, T_u: System, law: FirstOrderLaw, n_samples: int) -> "LiftedIteration":
        return cls(lifted_system(T_u, n_samples), *lifted_law(law, n_samples))

    @property
    def iteration(self) -> Array:
        """M_u - M_e T: what one iteration does to the distance from the fixed point."""
        return self.M_u - self.M_e @ self.T

    @property
    def spectral_radius(self) -> float:
        """Below 1: the iteration converges, perhaps after a long transient."""
        return float(np.abs(np.linalg.eigvals(self.iteration)).max())

    @property
    def contraction(self) -> float:
        """Largest singular value. Below 1: ||u_k - u_inf|| shrinks in every iteration."""
        return float(np.linalg.norm(self.iteration, ord=2))

    def fixed_point(self, first_error: Array) -> tuple[Array, Array]:
        """(u_inf, e_inf) for the error without correction, shape (N, n) each.

        Raises:
            ValueError: if the iteration has no fixed point.
        """
        matrix = np.eye(len(self.T)) - self.iteration
        try:
            u: Array = np.linalg.solve(matrix, self.M_e @ first_error).astype(np.float64)
        except np.linalg.LinAlgError as error:
            raise ValueError("the iteration has no fixed point: it has an eigenvalue 1") from error
        return u, first_error - self.T @ u

    def transient_growth(self, iterations: ArrayLike) -> Array:
        """||iteration^k||_2 at the given k: how far a transient can lift the distance.

        Bounded from above and below within a factor sqrt(N) by the Frobenius norm, which is what
        is computed, divided by sqrt(N) so that it never overstates.
        """
        norms = [
            np.linalg.norm(np.linalg.matrix_power(self.iteration, int(k)))
            for k in np.atleast_1d(iterations)
        ]
        return np.array(norms) / np.sqrt(len(self.T))
