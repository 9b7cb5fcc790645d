"""A linear model run along a record."""

import numpy as np
from numba import njit

from ..plant import Array


def simulate(A: Array, B0: Array, B1: Array, u: Array) -> Array:
    """x (N, n) of x_{i+1} = A x_i + B0 u_i + B1 u_{i+1} from x_0 = 0."""
    forcing = np.zeros((len(u), len(A)))
    forcing[1:] = u[:-1] @ B0.T + u[1:] @ B1.T
    return _run(np.ascontiguousarray(A), forcing)


@njit(cache=True)
def _run(A: Array, forcing: Array) -> Array:  # pragma: no cover - compiled
    x = np.empty_like(forcing)
    x[0] = forcing[0]
    for i in range(1, len(forcing)):
        x[i] = A @ x[i - 1] + forcing[i]
    return x
