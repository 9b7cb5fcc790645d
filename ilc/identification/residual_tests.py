"""Tests of the residuals of a fit against its inputs."""

import numpy as np

from armside.arrays import Array

from ..filters import recursion
from ..records import records

_PREWHITENING = 10  # order of the autoregression that makes residuals white


@records("residual", "u")
def independence(residual: Array, u: Array, lags: int = 20) -> float | None:
    """p-value that residuals (N, m) are uncorrelated with inputs (N, m) 0 to lags - 1 earlier.

    Small where the input still explains part of the residuals: the dynamics are of higher order,
    or not linear. Both are first filtered by an autoregression that makes the residuals white
    (Haugh 1976), so noise with a spectrum of its own is no evidence. None for records too short,
    or residuals of rounding alone.
    """
    from scipy.special import gammaincc

    n = len(residual)
    if n <= 5 * (lags + _PREWHITENING) or not residual.std() > 1e-12 * np.abs(residual).max():
        return None
    whitening = _autoregression(residual)
    e, x = (recursion(whitening, np.ones(1), s)[_PREWHITENING:] for s in (residual, u))
    past = np.stack([x[lags - 1 - i : len(x) - i] for i in range(lags)], axis=2).reshape(-1, lags)
    now = e[lags - 1 :].ravel()
    sums = past.T @ now
    statistic = sums @ np.linalg.lstsq(past.T @ past, sums, rcond=1e-10)[0] / now.var()
    return float(gammaincc(0.5 * lags, 0.5 * statistic))


def pairwise_independence(residual: Array, u: Array) -> float | None:
    """The least p-value of `independence` of residuals (N, p) and inputs (N, m), times p m.

    So many tests count as one (Bonferroni).
    """
    pairs = [(e[:, None], x[:, None]) for e in residual.T for x in u.T]
    values = [independence(*pair) for pair in pairs]
    found = [value for value in values if value is not None]
    return min(1.0, len(pairs) * min(found)) if found else None


def _autoregression(e: Array) -> Array:
    """1 + a_1 q^-1 + ..., by least squares."""
    n, p = len(e), _PREWHITENING
    past = np.stack([e[p - i : n - i] for i in range(1, p + 1)], axis=2).reshape(-1, p)
    return np.append(1.0, -np.linalg.lstsq(past, e[p:].ravel(), rcond=1e-10)[0])
