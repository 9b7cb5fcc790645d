"""State-space matrices as the compiled recursions take them: A block-diagonal, perhaps varying.

x(t + 1) = A(t) x(t) + B(t) u(t)        y(t) = C(t) x(t) + D(t) u(t)        x(0) = 0
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array, read_only


@dataclass(frozen=True, eq=False)
class Realisation:
    """Matrices with a leading axis of time: 1 if they do not vary, else N."""

    A: Array
    """(1 or N, b, size, size), the b diagonal blocks, smaller ones in the upper left corner."""
    first: NDArray[np.int64]
    """(b + 1,), first state of each block; the last entry is n."""
    B: Array
    """(1 or N, n, m)."""
    C: Array
    """(1 or N, p, n)."""
    D: Array
    """(1 or N, p, m)."""

    @classmethod
    def of(cls, A: Array, B: Array, C: Array, D: Array) -> "Realisation":
        """One block. A: (n, n), or (N, n, n) along the record, and so the others."""
        A, B, C, D = (M if M.ndim == 3 else M[None] for M in (A, B, C, D))
        first = np.array([0, A.shape[-1]], dtype=np.int64)
        return cls(np.ascontiguousarray(A[:, None]), first, *map(np.ascontiguousarray, (B, C, D)))

    @classmethod
    def of_blocks(cls, blocks: Sequence[Array], B: Array, C: Array, D: Array) -> "Realisation":
        """Time-invariant, from the diagonal blocks of A."""
        size = max((len(block) for block in blocks), default=1)
        A = np.zeros((1, len(blocks), size, size))
        for i, block in enumerate(blocks):
            A[0, i, : len(block), : len(block)] = block
        first = np.cumsum([0, *(len(block) for block in blocks)]).astype(np.int64)
        return cls(A, first, *(np.ascontiguousarray(M[None]) for M in (B, C, D)))

    def simulate(self, signal: Array) -> Array:
        """y (N, p) for u (N, m)."""
        from .block_recursion import states  # imported here: compiled

        x = states(read_only(self.A), self.first, _at_each_sample(self.B, signal))
        return _at_each_sample(self.C, x) + _at_each_sample(self.D, signal)

    def adjoint(self, signal: Array) -> Array:
        """T^T e (N, m) for e (N, p)."""
        return self._dual.simulate(signal[::-1])[::-1]

    @cached_property
    def _dual(self) -> "Realisation":
        """Model of the transposed matrices in reversed time: T^T between reversed records."""
        A, B, C, D = (
            np.ascontiguousarray(np.swapaxes(M[::-1], -1, -2))
            for M in (self.A, self.C, self.B, self.D)
        )
        return Realisation(A, self.first, B, C, D)


def _at_each_sample(M: Array, signal: Array) -> Array:
    """M(t) s(t), shape (N, rows), for M (1 or N, rows, columns)."""
    return signal @ M[0].T if len(M) == 1 else np.matmul(M, signal[:, :, None])[:, :, 0]


def filtered(
    A: Array, B: Array, C: Array, D: Array, taps: Array
) -> tuple[Array, Array, Array, Array]:
    """(A, B, C, D) of F T, F the finite impulse response `taps`: states of past outputs added."""
    lags, (p, m), n = len(taps) - 1, D.shape[-2:], A.shape[-1]
    lead = A.shape[:-2]
    grown = n + p * lags
    A_f, B_f = np.zeros((*lead, grown, grown)), np.zeros((*lead, grown, m))
    A_f[..., :n, :n], A_f[..., n : n + p, :n] = A, C
    A_f[..., n + p :, n:-p] = np.eye(p * (lags - 1))
    B_f[..., :n, :], B_f[..., n : n + p, :] = B, D
    C_f = np.zeros((*lead, p, grown))
    C_f[..., :n], C_f[..., n:] = taps[0] * C, np.kron(taps[1:], np.eye(p))
    return A_f, B_f, C_f, taps[0] * D
