"""Extended Kalman filter and smoother, linearised at every sample."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..records import as_measured, records

Step = Callable[[int, Array], tuple[Array, Array]]
"""(i, x) to the state at i + 1 and its Jacobian (n, n)."""
Measurement = Callable[[int, Array], tuple[Array, Array]]
"""(i, x) to the measurement at i, (p,), and its Jacobian (p, n)."""


@dataclass(frozen=True, eq=False)
class ExtendedResult:
    """Filtered and smoothed states (N, n), innovations (N, p) and covariances (N, n, n), (N, p, p).

    Innovations are NaN where the measurement is missing.
    """

    filtered: Array
    filtered_covariance: Array
    smoothed: Array
    innovation: Array
    innovation_covariance: Array


@records("y", gate=as_measured)
def extended(
    step: Step,
    measurement: Measurement,
    y: Array,
    Q: Array,
    R: Array,
    start: Array,
    start_covariance: Array,
) -> ExtendedResult:
    """Extended Kalman filter forwards, then fixed-interval smoother backwards (de Jong 1989).

    y: (N, p), NaN where a measurement is missing, such as between slower samples.
    """
    n_samples, n, p = len(y), len(start), y.shape[1]
    filtered, weighted = np.zeros((2, n_samples, n))
    covariance, blind, transition = np.empty((3, n_samples, n, n))
    innovation, S_all = np.full((n_samples, p), np.nan), np.zeros((n_samples, p, p))
    x, P = start.copy(), start_covariance.copy()
    for i in range(n_samples):
        blind[i] = np.eye(n)
        seen = np.flatnonzero(np.isfinite(y[i]))
        if seen.size:
            expected, C = measurement(i, x)
            channels = np.ix_(seen, seen)
            C, R_seen, e = C[seen], R[channels], y[i, seen] - expected[seen]
            S = C @ P @ C.T + R_seen
            K = np.linalg.solve(S, C @ P).T
            innovation[i, seen], S_all[i][channels] = e, S
            blind[i], weighted[i] = np.eye(n) - K @ C, C.T @ np.linalg.solve(S, e)
            x = x + K @ e
            P = blind[i] @ P @ blind[i].T + K @ R_seen @ K.T
        filtered[i], covariance[i] = x, P
        x, transition[i] = step(i, x)
        P = transition[i] @ P @ transition[i].T + Q
        P = 0.5 * (P + P.T)
    smoothed, r = np.empty_like(filtered), np.zeros(n)
    for i in range(n_samples - 1, -1, -1):  # as in `kalman.Smoother`
        ahead = r @ transition[i]
        smoothed[i] = filtered[i] + covariance[i] @ ahead
        r = weighted[i] + ahead @ blind[i]
    return ExtendedResult(filtered, covariance, smoothed, innovation, S_all)
