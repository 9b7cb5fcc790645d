"""Gains of the Riccati recursion for constant matrices and weights, without its matrix P.

From one sample to the one before, P grows by Z^T Z with as many rows as the model has outputs.
Updating Z instead of P costs O(n m p) a sample for n states, m inputs and p outputs, not O(n^2 m):

    [L  B^T Z^T]           [L_next       0     ]
    [           ] Theta =  [                   ],        Theta orthogonal
    [G  A^T Z^T]           [G_next     Z_next^T]

with G = (L^-1 (B^T P A + D^T W C))^T and L L^T = R + D^T W D + B^T P B. Morf, Sidhu and Kailath,
"Some new algorithms for recursive estimation in constant, linear, discrete-time systems" (1974).
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array

from ..models.block_recursion import SUMS, times_blocks
from ..models.blocks import Realisation

_STEADY = 1e-14  # growth of P a sample, relative to P in the trace, that is rounding


def constant_gains(
    model: Realisation, W: Array, R: Array, n_samples: int
) -> tuple[Array, Array, bool]:
    """Gains (M, m, n), L (M, m, m) and that H is regular, for weights W (p,) and R (m,).

    The last sample comes first; M <= n_samples is the number of samples until they are steady.
    """
    B, size = np.ascontiguousarray(model.B[0].T), np.sqrt(W)[:, None]
    C, D = size * model.C[0], size * model.D[0]
    gain, L, used = _gains(model.A[0], model.first, B, C, D, np.sqrt(R), n_samples)
    return gain[:used], L[:used], used > 0


@njit(cache=True, error_model="numpy", fastmath=SUMS)
def _gains(
    A: Array, first: NDArray[np.int64], B: Array, C: Array, D: Array, r: Array, n_samples: int
) -> tuple[Array, Array, int]:  # pragma: no cover - compiled
    """The number of gains is 0 if H is singular. B is transposed, r the square root of R."""
    m, n = B.shape
    p = len(C)
    gain, factors = np.empty((n_samples, m, n)), np.empty((n_samples, m, m))
    G, L = np.zeros((m, n)), np.diag(r)
    Z, V, moved, along = C.copy(), D.copy(), np.zeros((p, n)), np.zeros(n)
    trace = 0.0
    for k in range(n_samples):
        for j in range(m):  # reflections that turn column j of B^T Z^T into L
            squares = 0.0
            for o in range(p):
                squares += V[o, j] * V[o, j]
            norm = np.sqrt(L[j, j] * L[j, j] + squares)
            if not norm > 0.0:
                return gain, factors, 0
            if squares == 0.0:
                continue
            v = -squares / (L[j, j] + norm)
            scale = 2.0 / (v * v + squares)
            L[j, j] = norm
            for c in range(j + 1, m):
                value = v * L[c, j]
                for o in range(p):
                    value += V[o, j] * V[o, c]
                value *= scale
                L[c, j] -= value * v
                for o in range(p):
                    V[o, c] -= value * V[o, j]
            for i in range(n):
                along[i] = scale * v * G[j, i]
            for o in range(p):
                weight = scale * V[o, j]
                for i in range(n):
                    along[i] += weight * Z[o, i]
            for i in range(n):
                G[j, i] -= v * along[i]
            for o in range(p):
                weight = V[o, j]
                for i in range(n):
                    Z[o, i] -= weight * along[i]
        gain[k], factors[k] = G, L
        growth = 0.0
        for o in range(p):
            for i in range(n):
                growth += Z[o, i] * Z[o, i]
        trace += growth
        if growth <= _STEADY * trace:
            return gain, factors, k + 1
        for o in range(p):
            for j in range(m):
                value = 0.0
                for i in range(n):
                    value += Z[o, i] * B[j, i]
                V[o, j] = value
        times_blocks(A, first, Z, moved)
        Z, moved = moved, Z
    return gain, factors, n_samples
