"""Consistency tests: NEES, NIS and whiteness of innovations, independence of residuals from inputs.

NIS = e^T S^-1 e of an innovation e with covariance S is chi-squared with as many degrees of
freedom as e has entries; NEES likewise of an estimation error with the filter's P. Innovations of
a correct model are white.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import recursion
from ..records import as_measured, records


@dataclass(frozen=True)
class Whiteness:
    """Whiteness test of normalised innovations."""

    rms: Array
    """(p,), 1 for a correct model; above 1 the filter is optimistic, below 1 conservative."""
    correlation: Array
    """(lags, p), autocorrelation at lags 1, 2, ..."""
    p_value: Array
    """(p,), p-value of the Ljung-Box test; small if the correlations are significant."""

    @property
    def is_uncorrelated(self) -> bool:
        """No channel rejected at 1 % (Bonferroni over channels)."""
        return bool(self.p_value.min() >= 0.01 / len(self.p_value))

    @property
    def is_white(self) -> bool:
        """Uncorrelated, and every RMS at most 1.5."""
        return bool(self.is_uncorrelated and self.rms.max() <= 1.5)


@records("innovation", gate=as_measured)
def whiteness(innovation: Array, lags: int = 10) -> Whiteness:
    """Whiteness test of normalised innovations (N, p); missing rows are omitted."""
    from scipy.special import gammaincc

    e = innovation[np.isfinite(innovation).all(axis=1)]
    n = len(e)
    if n <= lags:
        raise ValueError(f"{lags} lags need more than {lags} samples, got {n}")
    centred = e - e.mean(axis=0)
    power = np.square(centred).sum(axis=0)
    lag = np.arange(1, lags + 1)
    rho = np.array([(centred[k:] * centred[:-k]).sum(axis=0) / power for k in lag])
    statistic = n * (n + 2.0) * (rho**2 / (n - lag)[:, None]).sum(axis=0)
    p_value = gammaincc(0.5 * lags, 0.5 * statistic)
    return Whiteness(np.sqrt(np.square(e).mean(axis=0)), rho, p_value)


@records("residual")
def residual_test(residual: Array, lags: int = 10) -> Whiteness | None:
    """Whiteness test of the residuals of a fit (N, m), scaled; None if records are too short."""
    scale = residual.std(axis=0)
    if len(residual) <= 5 * lags or not (scale > 1e-12 * np.abs(residual).max(axis=0)).all():
        return None
    return whiteness(residual / scale, lags)


@records("error")
def normalised_squared(error: Array, covariance: Array) -> Array:
    """NEES or NIS of each sample, (N,), from errors (N, p), covariances (N, p, p) or (1, p, p)."""
    return np.einsum("ij,ij->i", error, np.linalg.solve(covariance, error[:, :, None])[:, :, 0])


def bounds(n_samples: int, n_entries: int, confidence: float = 0.95) -> tuple[float, float]:
    """Confidence interval of the mean of n_samples NEES or NIS of a consistent filter."""
    from scipy.special import gammaincinv

    half_dof = 0.5 * n_samples * n_entries
    tail = 0.5 * (1.0 - confidence)
    low, high = (2.0 * gammaincinv(half_dof, p) / n_samples for p in (tail, 1.0 - tail))
    return float(low), float(high)


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
