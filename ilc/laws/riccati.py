"""Factors of a quadratic criterion over a finite record, for models in state-space form.

    minimise over d    1/2 d^T H d - g^T d,    H = G^T W G + R,

G a model in state-space form, W and R diagonal. Dynamic programming from the last sample
backwards factors H in O(N); every solution is then one recursion backwards and one forwards.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array, read_only

from ..models.block_recursion import SUMS, times_blocks
from ..models.blocks import Realisation

_STEADY = 1e-14  # growth of P a sample, relative to P in the trace, that is rounding


@njit(cache=True, error_model="numpy", fastmath=SUMS)
def _gains(
    A: Array, first: NDArray[np.int64], B: Array, C: Array, D: Array, r: Array, n_samples: int
) -> tuple[Array, Array, int]:  # pragma: no cover - compiled
    """Gains (M, m, n), L (M, m, m), last sample first, and M; M is 0 if H is singular.

    For constant matrices and weights, without P: from one sample to the one before, P grows by
    Z^T Z with as many rows as the model has outputs. Updating Z instead of P costs O(n m p) a
    sample for n states, m inputs and p outputs, not O(n^2 m):

        [L  B^T Z^T]           [L_next       0     ]
        [           ] Theta =  [                   ],        Theta orthogonal
        [G  A^T Z^T]           [G_next     Z_next^T]

    with G = (L^-1 (B^T P A + D^T W C))^T and L L^T = R + D^T W D + B^T P B. Morf, Sidhu and
    Kailath, "Some new algorithms for recursive estimation in constant, linear, discrete-time
    systems" (1974). B is transposed, r the square root of R, C and D times that of W.
    """
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


Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Factored:
    """Gains of the recursion, the last sample first; the last ones hold for all earlier samples.

    S = L L^T is the criterion of the correction of one sample, L^-1 G its coupling to the state.
    """

    model: Realisation
    gain: Array
    """(M, m, n), L^-1 G."""
    L: Array
    """(M, m, m), lower triangular; M <= N."""

    def solve(self, g: Array) -> Array:
        """d with H d = g, (N, m) each."""
        one = self.model
        matrices = (read_only(M) for M in (self._B, self.gain, self.L, g))
        return _solve(read_only(one.A), one.first, *matrices)

    @cached_property
    def _B(self) -> Array:
        """(1 or N, m, n)."""
        return np.ascontiguousarray(np.swapaxes(self.model.B, 1, 2))


def factor(model: Realisation, W: Array, R: Array) -> Factored:
    """Factor H for the weights of outputs W (N, p) and inputs R (N, m)."""
    W, R = np.ascontiguousarray(W), np.ascontiguousarray(R)
    A, *others = (read_only(M) for M in (model.A, model.B, model.C, model.D, W, R))
    fixed = all(len(M) == 1 for M in (model.A, model.B, model.C, model.D))
    if fixed and bool((W[0] == W).all() and (R[0] == R).all()):
        Bt, size = np.ascontiguousarray(model.B[0].T), np.sqrt(W[0])[:, None]
        weighted = size * model.C[0], size * model.D[0]
        gain, L, used = _gains(model.A[0], model.first, Bt, *weighted, np.sqrt(R[0]), len(W))
        gain, L, regular = gain[:used], L[:used], used > 0
    else:
        gain, L, regular = _varying_gains(A, model.first, *others)
    if not regular:
        remedy = "raise the weight of the correction or of its change"
        raise ValueError(f"the criterion does not determine the correction: {remedy}")
    return Factored(model, gain, L)


@njit(cache=True, error_model="numpy", fastmath=SUMS)
def _varying_gains(
    A: Array, first: Index, B: Array, C: Array, D: Array, W: Array, R: Array
) -> tuple[Array, Array, bool]:  # pragma: no cover - compiled
    """Riccati recursion; (gain, L) as of `Factored`, and that H is regular."""
    n_samples, m = R.shape
    n, p = B.shape[1], C.shape[1]
    gain, L = np.zeros((n_samples, m, n)), np.zeros((n_samples, m, m))
    P, PB, PA = np.zeros((n, n)), np.zeros((m, n)), np.zeros((n, n))
    for k in range(n_samples):
        t = n_samples - 1 - k
        ta, tb, tc, td = t % len(A), t % len(B), t % len(C), t % len(D)
        G, S = gain[k], L[k]
        # PB^T, S = R + D^T W D + B^T P B and G = B^T P A + D^T W C, P that of sample t + 1
        PB[:] = 0.0
        for i in range(n):
            for j in range(m):
                weight = B[tb, i, j]
                if weight != 0.0:
                    for c in range(n):
                        PB[j, c] += weight * P[i, c]
        for j in range(m):
            S[j, j] = R[t, j]
            for c in range(m):
                for o in range(p):
                    S[j, c] += D[td, o, j] * W[t, o] * D[td, o, c]
                for i in range(n):
                    S[j, c] += PB[j, i] * B[tb, i, c]
        times_blocks(A[ta], first, PB, G)
        for o in range(p):
            for j in range(m):
                weight = D[td, o, j] * W[t, o]
                if weight != 0.0:
                    for i in range(n):
                        G[j, i] += weight * C[tc, o, i]
        # L with S = L L^T, and L^-1 G, both in place
        for j in range(m):
            for c in range(j + 1):
                value = S[j, c]
                for i in range(c):
                    value -= S[j, i] * S[c, i]
                if c < j:
                    S[j, c] = value / S[c, c]
                elif not value > 0.0:
                    return gain, L, False
                else:
                    S[j, j] = np.sqrt(value)
            S[j, j + 1 :] = 0.0
            for c in range(j):
                for i in range(n):
                    G[j, i] -= S[j, c] * G[c, i]
            G[j] /= S[j, j]
        # P = A^T P A + C^T W C - G^T S^-1 G
        times_blocks(A[ta], first, P, PA)
        times_blocks(A[ta], first, PA.T.copy(), P)
        for o in range(p):
            for i in range(n):
                weight = W[t, o] * C[tc, o, i]
                if weight != 0.0:
                    for c in range(n):
                        P[i, c] += weight * C[tc, o, c]
        for j in range(m):
            for i in range(n):
                weight = G[j, i]
                for c in range(n):
                    P[i, c] -= weight * G[j, c]
        for i in range(n):
            for c in range(i):
                P[i, c] = P[c, i] = 0.5 * (P[i, c] + P[c, i])
    return gain, L, True


@njit(cache=True, error_model="numpy", fastmath=SUMS)
def _solve(
    A: Array, first: Index, B: Array, gain: Array, L: Array, g: Array
) -> Array:  # pragma: no cover - compiled
    n_samples, m = g.shape
    n, last = B.shape[2], len(L) - 1
    h, s, x = np.zeros((n_samples, m)), np.zeros((1, n)), np.zeros(n)
    following = np.zeros((1, n))
    for t in range(n_samples - 1, -1, -1):  # h = L^-1 (g + B^T s), s = A^T s - (L^-1 G)^T h
        now, tb = min(n_samples - 1 - t, last), t % len(B)
        times_blocks(A[t % len(A)], first, s, following)
        for j in range(m):
            value = g[t, j]
            for i in range(n):
                value += B[tb, j, i] * s[0, i]
            for c in range(j):
                value -= L[now, j, c] * h[t, c]
            value /= L[now, j, j]
            h[t, j] = value
            for i in range(n):
                following[0, i] -= gain[now, j, i] * value
        s, following = following, s
    new = following[0]
    for t in range(n_samples):  # d = L^-T (h - L^-1 G x), in h, and x = A x + B d
        now, ta, tb = min(n_samples - 1 - t, last), t % len(A), t % len(B)
        for block in range(len(first) - 1):
            start, size = first[block], first[block + 1] - first[block]
            for i in range(size):
                value = 0.0
                for c in range(size):
                    value += A[ta, block, i, c] * x[start + c]
                new[start + i] = value
        for j in range(m - 1, -1, -1):
            value = h[t, j]
            for i in range(n):
                value -= gain[now, j, i] * x[i]
            for c in range(j + 1, m):
                value -= L[now, c, j] * h[t, c]
            value /= L[now, j, j]
            h[t, j] = value
            for i in range(n):
                new[i] += B[tb, j, i] * value
        x, new = new, x
    return h
