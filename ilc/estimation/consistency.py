"""Whether a filter is right about its own errors: NEES, NIS and whiteness.

An innovation e of covariance S makes NIS = e^T S^-1 e, chi-squared with as many degrees of freedom
as e has entries; an estimation error makes NEES the same way with the filter's P. Innovations of a
correct model are white: no sample says anything of the next.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Whiteness:
    """Verdict on whitened innovations."""

    rms: Array
    """(p,), 1 for a right model. Above: the model explains too little; below: too much trust."""
    correlation: Array
    """(lags, p), autocorrelation at lags 1, 2, ..."""
    p_value: Array
    """(p,), of the Ljung-Box test: small where the correlations are no accident."""

    @property
    def is_white(self) -> bool:
        """No channel fails at 1 %, shared among the channels, and none is off by more than half."""
        enough = self.p_value.min() >= 0.01 / len(self.p_value)
        return bool(enough and self.rms.max() <= 1.5)


def whiteness(innovation: Array, lags: int = 10) -> Whiteness:
    """Of whitened innovations (N, p); rows that are missing are left out."""
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
    return Whiteness(
        rms=np.sqrt(np.square(e).mean(axis=0)),
        correlation=rho,
        p_value=gammaincc(0.5 * lags, 0.5 * statistic),
    )


def normalised_squared(error: Array, covariance: Array) -> Array:
    """NEES or NIS of each sample, (N,): errors (N, p), covariances (N, p, p) or (1, p, p)."""
    return np.einsum("ij,ij->i", error, np.linalg.solve(covariance, error[:, :, None])[:, :, 0])


def bounds(n_samples: int, n_entries: int, confidence: float = 0.95) -> tuple[float, float]:
    """Within which the mean of n_samples NEES or NIS lies, if the filter is consistent."""
    from scipy.special import gammaincinv

    half_dof = 0.5 * n_samples * n_entries
    tail = 0.5 * (1.0 - confidence)
    low, high = (2.0 * gammaincinv(half_dof, p) / n_samples for p in (tail, 1.0 - tail))
    return float(low), float(high)
