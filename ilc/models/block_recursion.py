"""Compiled recursions in time: states of block-diagonal models, matrices of filters.

Matrices have a leading axis of time of length 1 or N; see `blocks.Realisation`.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array

Index = NDArray[np.int64]
SUMS = {"reassoc", "contract", "nsz"}
"""Freedom of the compiler in sums of products: order and fused operations, nothing else."""


@njit(cache=True, error_model="numpy", fastmath=SUMS)
def states(A: Array, first: Index, drive: Array) -> Array:  # pragma: no cover - compiled
    """x (N, n) of x(t + 1) = A(t) x(t) + drive(t), x(0) = 0."""
    x = np.zeros_like(drive)
    for t in range(len(drive) - 1):
        a = t % len(A)
        for block in range(len(first) - 1):
            start, size = first[block], first[block + 1] - first[block]
            for i in range(size):
                value = drive[t, start + i]
                for k in range(size):
                    value += A[a, block, i, k] * x[t, start + k]
                x[t + 1, start + i] = value
    return x


@njit(cache=True, error_model="numpy", fastmath=SUMS)
def times_blocks(
    A: Array, first: Index, X: Array, product: Array
) -> None:  # pragma: no cover - compiled
    """X A (r, n) for the blocks A (b, size, size) of one sample, into `product`."""
    for row in range(len(X)):
        for block in range(len(first) - 1):
            start, size = first[block], first[block + 1] - first[block]
            for c in range(size):
                value = 0.0
                for i in range(size):
                    value += X[row, start + i] * A[block, i, c]
                product[row, start + c] = value


@njit(cache=True, error_model="numpy", fastmath=SUMS)
def filter_matrix(b: Array, a: Array, u: Array) -> Array:  # pragma: no cover - compiled
    """y_i = sum_j b_ij / a_ij u_j for coefficients (p, m, order + 1), powers of q^-1, a[0] = 1."""
    p, m, size = b.shape
    y, w = np.zeros((len(u), p)), np.zeros(size)
    for i in range(p):
        for j in range(m):
            if not b[i, j].any():
                continue
            w[:] = 0.0  # partial sums of the transposed direct form
            for t in range(len(u)):
                given = u[t, j]
                found = b[i, j, 0] * given + w[0]
                for lag in range(1, size):
                    w[lag - 1] = w[lag] + b[i, j, lag] * given - a[i, j, lag] * found
                y[t, i] += found
    return y
