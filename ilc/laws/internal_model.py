"""Internal model principle over the iterations: rejects a known pattern (thesis 7.6)."""

import numpy as np
from numpy.typing import ArrayLike

from ..filters import ALL_PASS, RecordFilter
from .high_order import HighOrder


def periodic_pattern(period: int) -> tuple[float, ...]:
    """D(w) = 1 - w^period: all patterns with this period over the iterations."""
    if period < 1:
        raise ValueError(f"period must be >= 1, got {period}")
    return (1.0, *([0.0] * (period - 1)), -1.0)


def internal_model(
    pattern: ArrayLike, *, L: RecordFilter, Q: RecordFilter = ALL_PASS, pole: float = 0.1
) -> HighOrder:
    """High-order law without asymptotic error for disturbances with D(w) d_k = 0.

    pattern: coefficients (1, d_1, ..., d_p) of D in the backward iteration shift w, as
    `periodic_pattern` returns. L: an approximate inverse of T_u. pole: all p poles of the
    iteration for L T_u = 1, in [0, 1). After Chen and Moore (2002).

    With D(w) u = K(w) L e, e = e_0 - T_u u and L T_u = 1 the error is D / (D + K) e_0; K = A - D
    places the poles A(w) = (1 - pole w)^p.
    """
    D = np.asarray(pattern, dtype=np.float64)
    if D.ndim != 1 or len(D) < 2 or D[0] != 1.0 or not np.isfinite(D).all():
        raise ValueError(f"pattern must be (1, d_1, ..., d_p) with p >= 1, got {pattern}")
    if not 0.0 <= pole < 1.0:
        raise ValueError(f"pole must be in [0, 1), got {pole}")
    A = np.poly(np.full(len(D) - 1, pole))
    return HighOrder(alpha=tuple((-D[1:]).tolist()), beta=tuple((A - D)[1:].tolist()), L=L, Q=Q)
