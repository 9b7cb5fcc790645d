"""Compiled recursions of block-diagonal state-space models: records forwards, adjoints backwards.

Matrices have a leading axis of time of length 1 or N; see `blocks.Realisation`.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array

Index = NDArray[np.int64]


@njit(cache=True, error_model="numpy")
def forward(
    A: Array, first: Index, B: Array, C: Array, D: Array, u: Array
) -> Array:  # pragma: no cover - compiled
    n_samples, m = u.shape
    n, p = B.shape[1], C.shape[1]
    y = np.zeros((n_samples, p))
    x, following = np.zeros(n), np.zeros(n)
    for t in range(n_samples):
        a, b, c, d = t % len(A), t % len(B), t % len(C), t % len(D)
        for o in range(p):
            for i in range(n):
                y[t, o] += C[c, o, i] * x[i]
            for j in range(m):
                y[t, o] += D[d, o, j] * u[t, j]
        for i in range(n):
            following[i] = 0.0
            for j in range(m):
                following[i] += B[b, i, j] * u[t, j]
        for block in range(len(first) - 1):
            start, size = first[block], first[block + 1] - first[block]
            for i in range(size):
                for k in range(size):
                    following[start + i] += A[a, block, i, k] * x[start + k]
        x, following = following, x
    return y


@njit(cache=True, error_model="numpy")
def backward(
    A: Array, first: Index, B: Array, C: Array, D: Array, e: Array
) -> Array:  # pragma: no cover - compiled
    n_samples, p = e.shape
    n, m = B.shape[1], B.shape[2]
    u = np.zeros((n_samples, m))
    s, following = np.zeros(n), np.zeros(n)
    for t in range(n_samples - 1, -1, -1):  # u = B^T s + D^T e, s = A^T s + C^T e
        a, b, c, d = t % len(A), t % len(B), t % len(C), t % len(D)
        for i in range(n):
            for j in range(m):
                u[t, j] += B[b, i, j] * s[i]
        following[:] = 0.0
        for o in range(p):
            for j in range(m):
                u[t, j] += D[d, o, j] * e[t, o]
            for i in range(n):
                following[i] += C[c, o, i] * e[t, o]
        for block in range(len(first) - 1):
            start, size = first[block], first[block + 1] - first[block]
            for i in range(size):
                for k in range(size):
                    following[start + k] += A[a, block, i, k] * s[start + i]
        s, following = following, s
    return u
