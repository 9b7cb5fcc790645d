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
    """Extended Kalman filter forwards, then Rauch-Tung-Striebel smoother backwards.

    y: (N, p), a row of NaN where the measurement is missing, such as between slower samples.
    """
    n_samples, n, p = len(y), len(start), y.shape[1]
    filtered, ahead = np.empty((2, n_samples, n))
    covariance, ahead_covariance, transition = np.empty((3, n_samples, n, n))
    innovation, S_all = np.full((n_samples, p), np.nan), np.zeros((n_samples, p, p))
    x, P = start.copy(), start_covariance.copy()
    for i in range(n_samples):
        if np.isfinite(y[i]).all():
            predicted, C = measurement(i, x)
            S = C @ P @ C.T + R
            K = np.linalg.solve(S, C @ P).T
            innovation[i], S_all[i] = y[i] - predicted, S
            x = x + K @ innovation[i]
            I_KC = np.eye(n) - K @ C
            P = I_KC @ P @ I_KC.T + K @ R @ K.T
        filtered[i], covariance[i] = x, P
        x, A = step(i, x)
        P = A @ P @ A.T + Q
        P = 0.5 * (P + P.T)
        ahead[i], ahead_covariance[i], transition[i] = x, P, A
    smoothed = filtered.copy()
    for i in range(n_samples - 2, -1, -1):
        back = np.linalg.solve(ahead_covariance[i], transition[i] @ covariance[i]).T
        smoothed[i] += back @ (smoothed[i + 1] - ahead[i])
    return ExtendedResult(filtered, covariance, smoothed, innovation, S_all)
