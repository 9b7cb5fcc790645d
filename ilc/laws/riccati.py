"""Riccati recursion of a quadratic criterion over a finite record, compiled.

    minimise over d    1/2 d^T H d - g^T d,    H = G^T W G + R,

G a model in state-space form, W and R diagonal. Dynamic programming from the last sample
backwards factors H in O(N); every solution is then one recursion backwards and one forwards.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array

from ..models.blocks import Realisation

_STEADY = 1e-14  # relative change of P a sample at which the recursion is in its steady state
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Factored:
    """Gains of the recursion: K (N, m, n), and S (N, m, m) as its Cholesky factor."""

    model: Realisation
    K: Array
    S: Array

    def solve(self, g: Array) -> Array:
        """d with H d = g, (N, m) each."""
        one = self.model
        return _solve(one.A, one.first, one.B, self.K, self.S, np.ascontiguousarray(g))


def factor(model: Realisation, W: Array, R: Array) -> Factored:
    """Factor H for the weights of outputs W (N, p) and inputs R (N, m).

    Raises ValueError if H is singular: some correction has neither an effect nor a weight.
    """
    fixed = all(len(M) == 1 for M in (model.A, model.B, model.C, model.D))
    constant = fixed and bool((W[0] == W).all() and (R[0] == R).all())
    W, R = np.ascontiguousarray(W), np.ascontiguousarray(R)
    matrices = model.A, model.first, model.B, model.C, model.D
    K, S, regular = _factor(*matrices, W, R, _STEADY if constant else -1.0)
    if not regular:
        remedy = "raise the weight of the correction or of its change"
        raise ValueError(f"the criterion does not determine the correction: {remedy}")
    return Factored(model, K, S)


@njit(cache=True, error_model="numpy")
def _factor(
    A: Array, first: Index, B: Array, C: Array, D: Array, W: Array, R: Array, steady: float
) -> tuple[Array, Array, bool]:  # pragma: no cover - compiled
    n_samples, m = R.shape
    n, p = B.shape[1], C.shape[1]
    K, S = np.zeros((n_samples, m, n)), np.zeros((n_samples, m, m))
    P, PB, PA = np.zeros((n, n)), np.zeros((m, n)), np.zeros((n, n))
    G, following = np.zeros((m, n)), np.zeros((n, n))
    for t in range(n_samples - 1, -1, -1):
        ta, tb, tc, td = t % len(A), t % len(B), t % len(C), t % len(D)
        # PB^T, S = R + D^T W D + B^T P B and G = B^T P A + D^T W C, P that of sample t + 1
        PB[:] = 0.0
        for i in range(n):
            for j in range(m):
                weight = B[tb, i, j]
                if weight != 0.0:
                    for k in range(n):
                        PB[j, k] += weight * P[i, k]
        S[t] = 0.0
        for j in range(m):
            S[t, j, j] = R[t, j]
            for k in range(m):
                for o in range(p):
                    S[t, j, k] += D[td, o, j] * W[t, o] * D[td, o, k]
                for i in range(n):
                    S[t, j, k] += PB[j, i] * B[tb, i, k]
        G[:], PA[:] = 0.0, 0.0
        for b in range(len(first) - 1):
            start, size = first[b], first[b + 1] - first[b]
            for i in range(size):
                for j in range(m):
                    for c in range(size):
                        G[j, start + c] += PB[j, start + i] * A[ta, b, i, c]
            for row in range(n):
                for i in range(size):
                    for c in range(size):
                        PA[row, start + c] += P[row, start + i] * A[ta, b, i, c]
        for o in range(p):
            for j in range(m):
                weight = D[td, o, j] * W[t, o]
                if weight != 0.0:
                    for i in range(n):
                        G[j, i] += weight * C[tc, o, i]
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
        for b in range(len(first) - 1):
            start, size = first[b], first[b + 1] - first[b]
            for c in range(size):
                for i in range(size):
                    weight = A[ta, b, i, c]
                    for k in range(n):
                        following[start + c, k] += weight * PA[start + i, k]
        for o in range(p):
            for i in range(n):
                weight = W[t, o] * C[tc, o, i]
                if weight != 0.0:
                    for k in range(n):
                        following[i, k] += weight * C[tc, o, k]
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


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _solve(
    A: Array, first: Index, B: Array, K: Array, S: Array, g: Array
) -> Array:  # pragma: no cover - compiled
    n_samples, m = g.shape
    n = B.shape[1]
    d = g.copy()
    s, following = np.zeros(n), np.zeros(n)
    for t in range(n_samples - 1, -1, -1):  # w = g + B^T s, s = A^T s - K^T w
        ta, tb = t % len(A), t % len(B)
        for i in range(n):
            for j in range(m):
                d[t, j] += B[tb, i, j] * s[i]
        following[:] = 0.0
        for b in range(len(first) - 1):
            start, size = first[b], first[b + 1] - first[b]
            for i in range(size):
                for c in range(size):
                    following[start + c] += A[ta, b, i, c] * s[start + i]
        for j in range(m):
            for i in range(n):
                following[i] -= K[t, j, i] * d[t, j]
        s, following = following, s
    x = np.zeros(n)
    for t in range(n_samples):  # d = S^-1 w - K x, x = A x + B d
        ta, tb = t % len(A), t % len(B)
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
        for i in range(n):
            following[i] = 0.0
            for j in range(m):
                following[i] += B[tb, i, j] * d[t, j]
        for b in range(len(first) - 1):
            start, size = first[b], first[b + 1] - first[b]
            for i in range(size):
                for c in range(size):
                    following[start + i] += A[ta, b, i, c] * x[start + c]
        x, following = following, x
    return d
