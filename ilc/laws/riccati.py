"""Riccati recursion of a quadratic criterion over a finite record, compiled.

    minimise over d    1/2 d^T H d - g^T d,    H = G^T W G + R,

G a model in state-space form, W and R diagonal. Dynamic programming from the last sample
backwards factors H in O(N); every solution is then one recursion backwards and one forwards.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array

from ..models.realisation import Realisation

_STEADY = 1e-14  # relative change of P a sample at which the recursion is in its steady state


class _Blocks(NamedTuple):
    """Blocks of A in one array (b, size, size), with the first state and the input of each."""

    A: Array
    first: NDArray[np.int64]
    inputs: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Factored:
    """Gains of the recursion: K (N, m, n), and S (N, m, m) as its Cholesky factor."""

    model: Realisation
    blocks: _Blocks
    K: Array
    S: Array

    def solve(self, g: Array) -> Array:
        """d with H d = g, (N, m) each."""
        return _solve(self.blocks, self.model.B, self.K, self.S, np.ascontiguousarray(g))


def factor(model: Realisation, W: Array, R: Array) -> Factored:
    """Factor H for the weights of outputs W (N, p) and inputs R (N, m).

    Raises ValueError if H is singular: some correction has neither an effect nor a weight.
    """
    size = max((len(A) for A in model.blocks), default=1)
    A = np.zeros((len(model.blocks), size, size))
    for block, given in zip(A, model.blocks, strict=True):
        block[: len(given), : len(given)] = given
    first = np.cumsum([0, *(len(given) for given in model.blocks)])
    blocks = _Blocks(A, first, np.array(model.inputs, dtype=np.int64))
    constant = bool((W[0] == W).all() and (R[0] == R).all())
    W, R = np.ascontiguousarray(W), np.ascontiguousarray(R)
    K, S, regular = _factor(blocks, model.B, model.C, model.D, W, R, _STEADY if constant else -1.0)
    if not regular:
        remedy = "raise the weight of the correction or of its change"
        raise ValueError(f"the criterion does not determine the correction: {remedy}")
    return Factored(model, blocks, K, S)


@njit(cache=True, error_model="numpy")
def _factor(
    blocks: _Blocks, B: Array, C: Array, D: Array, W: Array, R: Array, steady: float
) -> tuple[Array, Array, bool]:  # pragma: no cover - compiled
    n_samples, m = R.shape
    n, p = len(B), len(C)
    K, S = np.zeros((n_samples, m, n)), np.zeros((n_samples, m, m))
    P, PB, PA = np.zeros((n, n)), np.zeros((m, n)), np.zeros((n, n))
    G, following = np.zeros((m, n)), np.zeros((n, n))
    for t in range(n_samples - 1, -1, -1):
        # PB^T, S = R + D^T W D + B^T P B and G = B^T P A + D^T W C, P that of sample t + 1
        PB[:] = 0.0
        for b in range(len(blocks.inputs)):
            j = blocks.inputs[b]
            for i in range(blocks.first[b], blocks.first[b + 1]):
                for k in range(n):
                    PB[j, k] += B[i] * P[i, k]
        S[t] = 0.0
        for j in range(m):
            S[t, j, j] = R[t, j]
            for k in range(m):
                for o in range(p):
                    S[t, j, k] += D[o, j] * W[t, o] * D[o, k]
        G[:] = 0.0
        for b in range(len(blocks.inputs)):
            k = blocks.inputs[b]
            start, size = blocks.first[b], blocks.first[b + 1] - blocks.first[b]
            for i in range(size):
                for j in range(m):
                    S[t, j, k] += PB[j, start + i] * B[start + i]
                    for c in range(size):
                        G[j, start + c] += PB[j, start + i] * blocks.A[b, i, c]
                for row in range(n):
                    if i == 0:
                        for c in range(size):
                            PA[row, start + c] = 0.0
                    for c in range(size):
                        PA[row, start + c] += P[row, start + i] * blocks.A[b, i, c]
        for o in range(p):
            for j in range(m):
                weight = D[o, j] * W[t, o]
                if weight != 0.0:
                    for i in range(n):
                        G[j, i] += weight * C[o, i]
        # Cholesky factor of S in place, and K = S^-1 G
        for j in range(m):
            for k in range(j + 1):
                value = S[t, j, k]
                for i in range(k):
                    value -= S[t, j, i] * S[t, k, i]
                if k < j:
                    S[t, j, k] = value / S[t, k, k]
                else:
                    if not value > 0.0:
                        return K, S, False
                    S[t, j, j] = np.sqrt(value)
            for k in range(j + 1, m):
                S[t, j, k] = 0.0
        for j in range(m):
            for i in range(n):
                K[t, j, i] = G[j, i]
            for k in range(j):
                for i in range(n):
                    K[t, j, i] -= S[t, j, k] * K[t, k, i]
            for i in range(n):
                K[t, j, i] /= S[t, j, j]
        # P = A^T P A + C^T W C - G^T S^-1 G, with K = L^-1 G up to here
        following[:] = 0.0
        for b in range(len(blocks.inputs)):
            start, size = blocks.first[b], blocks.first[b + 1] - blocks.first[b]
            for c in range(size):
                for i in range(size):
                    for k in range(n):
                        following[start + c, k] += blocks.A[b, i, c] * PA[start + i, k]
        for o in range(p):
            for i in range(n):
                weight = W[t, o] * C[o, i]
                if weight != 0.0:
                    for k in range(n):
                        following[i, k] += weight * C[o, k]
        for j in range(m):
            for i in range(n):
                weight = K[t, j, i]
                for k in range(n):
                    following[i, k] -= weight * K[t, j, k]
        for j in range(m - 1, -1, -1):
            for k in range(j + 1, m):
                for i in range(n):
                    K[t, j, i] -= S[t, k, j] * K[t, k, i]
            for i in range(n):
                K[t, j, i] /= S[t, j, j]
        change, largest = 0.0, 0.0
        for i in range(n):
            for k in range(i + 1):
                value = 0.5 * (following[i, k] + following[k, i])
                change = max(change, abs(value - P[i, k]))
                largest = max(largest, abs(value))
                P[i, k] = value
                P[k, i] = value
        if change <= steady * largest:
            K[:t], S[:t] = K[t], S[t]
            break
    return K, S, True


@njit(cache=True, error_model="numpy")
def _solve(
    blocks: _Blocks, B: Array, K: Array, S: Array, g: Array
) -> Array:  # pragma: no cover - compiled
    n_samples, m = g.shape
    n = len(B)
    d = g.copy()
    s, following = np.zeros(n), np.zeros(n)
    for t in range(n_samples - 1, -1, -1):  # w = g + B^T s, s = A^T s - K^T w
        for b in range(len(blocks.inputs)):
            for i in range(blocks.first[b], blocks.first[b + 1]):
                d[t, blocks.inputs[b]] += B[i] * s[i]
        following[:] = 0.0
        for b in range(len(blocks.inputs)):
            start, size = blocks.first[b], blocks.first[b + 1] - blocks.first[b]
            for i in range(size):
                for c in range(size):
                    following[start + c] += blocks.A[b, i, c] * s[start + i]
        for j in range(m):
            for i in range(n):
                following[i] -= K[t, j, i] * d[t, j]
        s, following = following, s
    x = np.zeros(n)
    for t in range(n_samples):  # d = S^-1 w - K x, x = A x + B d
        for j in range(m):
            for k in range(j):
                d[t, j] -= S[t, j, k] * d[t, k]
            d[t, j] /= S[t, j, j]
        for j in range(m - 1, -1, -1):
            for k in range(j + 1, m):
                d[t, j] -= S[t, k, j] * d[t, k]
            d[t, j] /= S[t, j, j]
        for j in range(m):
            for i in range(n):
                d[t, j] -= K[t, j, i] * x[i]
        following[:] = 0.0
        for b in range(len(blocks.inputs)):
            start, size = blocks.first[b], blocks.first[b + 1] - blocks.first[b]
            for i in range(size):
                following[start + i] += B[start + i] * d[t, blocks.inputs[b]]
                for c in range(size):
                    following[start + i] += blocks.A[b, i, c] * x[start + c]
        x, following = following, x
    return d
