"""State-space model in innovations form, and what a fit of it says.

x_{i+1} = A x_i + B u_i + K e_i        y_i = C x_i + D u_i + e_i        E[e e^T] = S
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.state_space import StateSpace
from ..models.system import Complex
from ..records import records


@dataclass(frozen=True, kw_only=True, eq=False)
class InnovationsForm:
    """Shapes: A (n, n), B (n, m), C (p, n), D (p, m), K (n, p), S (p, p)."""

    A: Array
    B: Array
    C: Array
    D: Array
    K: Array
    S: Array
    sample_time: float
    """[s]."""

    @cached_property
    def system(self) -> StateSpace:
        """From u to y, as laws and analysis take it."""
        return StateSpace(self.A, self.B, self.C, self.D, self.sample_time)

    @property
    def order(self) -> int:
        return len(self.A)

    @property
    def poles(self) -> Complex:
        return np.linalg.eigvals(self.A).astype(np.complex128)

    def response(self, omega: ArrayLike) -> Complex:
        """From u to y, (M, p, m), at omega (M,) [rad/sample]."""
        return self.system.response(omega)

    @records("u")
    def simulate(self, u: Array) -> Array:
        """Outputs (N, p) of inputs (N, m) from rest, without noise."""
        return self.system.simulate(u)

    @records("u", "y", alike=False)
    def innovations(self, u: Array, y: Array, start: ArrayLike | None = None) -> Array:
        """One-step prediction errors e (N, p) from `start` (n,), 0 if None."""
        x = np.zeros(self.order) if start is None else np.asarray(start, dtype=np.float64)
        forcing = u @ (self.B - self.K @ self.D).T + y @ self.K.T
        x = states(self.A - self.K @ self.C, forcing, x)
        return y - x @ self.C.T - u @ self.D.T


@records("forcing")
def states(A: Array, forcing: Array, start: Array | None = None) -> Array:
    """x (N, n) of x_{i+1} = A x_i + forcing_i."""
    first = np.zeros(len(A)) if start is None else start
    return _states(np.ascontiguousarray(A), np.ascontiguousarray(forcing), first.copy())


@njit(cache=True)
def _states(A: Array, forcing: Array, x: Array) -> Array:  # pragma: no cover - compiled
    found = np.empty_like(forcing)
    for i in range(len(forcing)):
        found[i] = x
        x = A @ x + forcing[i]
    return found
