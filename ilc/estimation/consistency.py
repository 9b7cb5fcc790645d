"""Consistency tests of a Kalman filter: NEES, NIS and whiteness of the innovations.

NIS = e^T S^-1 e of an innovation e with covariance S is chi-squared with as many degrees of
freedom as e has entries; NEES likewise of an estimation error with the filter's P. Innovations of
a correct model are white.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

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
