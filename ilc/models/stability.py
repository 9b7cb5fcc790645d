"""Stability of a polynomial, decided exactly for the coefficients as they are stored."""

from fractions import Fraction

import numpy as np

from armside.arrays import Array


def is_stable(a: Array) -> bool:
    """All roots of a[0] z^n + ... + a[n] are inside the unit circle.

    They are if and only if the matrix of Schur and Cohn is positive definite. Its leading minors
    are computed in whole numbers (Bareiss), for close, slow poles differ by less than rounding.
    """
    c = _whole(np.trim_zeros(a, "b"))
    n = len(c) - 1
    M = [
        [
            sum(c[i - k] * c[j - k] - c[n - i + k] * c[n - j + k] for k in range(min(i, j) + 1))
            for j in range(n)
        ]
        for i in range(n)
    ]
    before = 1
    for k in range(n):
        pivot = M[k][k]  # the leading minor of order k + 1
        if pivot <= 0:
            return False
        for i in range(k + 1, n):
            for j in range(k + 1, n):
                M[i][j] = (M[i][j] * pivot - M[i][k] * M[k][j]) // before
        before = pivot
    return True


def _whole(a: Array) -> list[int]:
    """Coefficients times the power of two that makes all of them whole numbers."""
    exact = [Fraction(float(p)) for p in a]
    scale = max(p.denominator for p in exact)
    return [int(p * scale) for p in exact]
