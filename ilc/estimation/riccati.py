"""The covariance at which a Kalman filter settles, by structured doubling."""

import numpy as np

from ..plant import Array
from .state_space import Process

_DOUBLINGS = 40  # 2^40 samples: a bias that wanders very slowly has settled by then
_SETTLED = 1e-10


def settled(process: Process) -> Array:
    """P, shape (n, n), of the one-step prediction error. Each doubling looks twice as far back.

    Raises:
        RuntimeError: the filter does not settle: a state is neither seen nor stable.
    """
    n = len(process.A)
    # P_{k+1} = Q + A (P_k^-1 + C^T R^-1 C)^-1 A^T from P_0 = 0, in steps of 1, 2, 4, ...
    A, G, H = process.A.T, process.C.T @ np.linalg.solve(process.R, process.C), process.Q
    for _ in range(_DOUBLINGS):
        W = np.eye(n) + G @ H
        WA, WG = np.split(np.linalg.solve(W, np.hstack((A, G))), 2, axis=1)
        grown = A.T @ H @ WA
        G = G + A @ WG @ A.T
        A = A @ WA
        H = H + 0.5 * (grown + grown.T)
        G = 0.5 * (G + G.T)
        if not np.isfinite(H).all():
            break
        if np.abs(grown).max() <= _SETTLED * np.abs(H).max():
            return H
    raise RuntimeError("the filter does not settle: a state is neither seen nor stable")
