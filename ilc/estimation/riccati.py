"""The covariance at which a Kalman filter settles, by structured doubling."""

import numpy as np
from numba import njit

from ..plant import Array
from .state_space import Process

_DOUBLINGS = 40  # 2^40 samples: a bias that wanders very slowly has settled by then
_SETTLED = 1e-10


def settled(process: Process) -> Array:
    """P, shape (n, n), of the one-step prediction error. Each doubling looks twice as far back.

    Raises:
        RuntimeError: the filter does not settle: a state is neither seen nor stable.
    """
    R_C = np.linalg.solve(process.R, process.C)
    H, steps = _doubled(np.ascontiguousarray(process.A.T), process.C.T @ R_C, process.Q)
    if steps == 0:
        raise RuntimeError("the filter does not settle: a state is neither seen nor stable")
    return H


@njit(cache=True)
def _doubled(A: Array, G: Array, H: Array) -> tuple[Array, int]:  # pragma: no cover - compiled
    """P and the doublings it took, 0 where it does not settle.

    P_{k+1} = Q + A (P_k^-1 + C^T R^-1 C)^-1 A^T from P_0 = 0, in steps of 1, 2, 4, ...
    """
    n = len(A)
    both = np.empty((n, 2 * n))
    for step in range(1, _DOUBLINGS + 1):
        both[:, :n], both[:, n:] = A, G
        solved = np.linalg.solve(np.eye(n) + G @ H, both)
        WA = np.ascontiguousarray(solved[:, :n])
        WG = np.ascontiguousarray(solved[:, n:])
        transposed = np.ascontiguousarray(A.T)
        grown = transposed @ H @ WA
        G = G + A @ WG @ transposed
        A = A @ WA
        H = H + 0.5 * (grown + grown.T)
        G = 0.5 * (G + G.T)
        if not np.isfinite(H).all():
            return H, 0
        if np.abs(grown).max() <= _SETTLED * np.abs(H).max():
            return H, step
    return H, 0
