"""Kinematic Kalman filter of one angle, whose noise is found by expectation-maximisation.

    x_{k+1} = A x_k + B u_k + w_k        y_k = theta_k + v_k        x = (theta, theta')

u is a measured acceleration, y a rough angle; Q = E[w w^T] and R = E[v^2] are unknown. Shumway and
Stoffer, J. Time Series Analysis 3(4), 1982.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from armside.arrays import Array

from ..records import as_record

ITERATIONS = 30
"""Of expectation-maximisation. Twice as many change an angle of the M16iB-like arm by less than a
microradian. ESTIMATE"""
FIRST = 1e-4, 1.0
"""Noise to begin with: of the angle [rad] and of the acceleration [rad/s^2]. ESTIMATE"""
AT_START = np.diag([1e-8, 1e-6])
"""Covariance of a start at rest at the first angle. ESTIMATE"""


@dataclass(frozen=True, kw_only=True)
class KinematicFilter:
    """Filter and smoother for samples every `step` [s]."""

    step: float
    iterations: int = ITERATIONS

    @property
    def process(self) -> tuple[Array, Array]:
        """A (2, 2) and B (2,)."""
        h = self.step
        return np.array([[1.0, h], [0.0, 1.0]]), np.array([0.5 * h**2, h])

    def smoothed(self, angle: Array, acceleration: Array) -> Array:
        """(N, 2), angle and rate by all samples (N,), with noise of the whole record."""
        angle, acceleration = _columns(angle=angle, acceleration=acceleration)
        start = np.array([angle[0], 0.0]), AT_START
        known = self._learned(angle, acceleration, *self._first_noise, *start)
        return _smoother(*self.process, *known, angle, acceleration, *start)[0]

    def filtered(self, angle: Array, acceleration: Array, window: int) -> Array:
        """(N, 2), angle and rate by the samples up to each; noise is that of the window of so many
        samples that ended last."""
        angle, acceleration = _columns(angle=angle, acceleration=acceleration)
        A, B = self.process
        Q, R = self._first_noise
        found = np.empty((len(angle), 2))
        x, P = np.array([angle[0], 0.0]), AT_START
        for first in range(0, len(angle), window):
            now = slice(first, first + window)
            means, _, ahead, of_ahead = _filter(A, B, Q, R, angle[now], acceleration[now], x, P)
            if len(angle[now]) == window:
                Q, R = self._learned(angle[now], acceleration[now], Q, R, x, P)
            found[now], x, P = means, ahead[-1], of_ahead[-1]
        return found

    @property
    def _first_noise(self) -> tuple[Array, float]:
        """Q (2, 2) and R."""
        _, B = self.process
        angle, acceleration = FIRST
        return acceleration**2 * np.outer(B, B) + 1e-18 * np.eye(2), angle**2

    def _learned(
        self, angle: Array, acceleration: Array, Q: Array, R: float, x: Array, P: Array
    ) -> tuple[Array, float]:
        """Q and R of samples, from those before; x, P: what is known ahead of the first sample."""
        A, B = self.process
        for _ in range(self.iterations):
            _, Q, R = _smoother(A, B, Q, R, angle, acceleration, x, P)
        return Q, R


def _columns(**signals: Array) -> list[Array]:
    """Signals (N,) that are finite and equally long; ValueError for others."""
    found = [as_record(np.atleast_2d(value).T, name)[:, 0] for name, value in signals.items()]
    if len({len(each) for each in found}) > 1:
        raise ValueError(f"{' and '.join(signals)} must have equally many samples")
    return found


@njit(cache=True)
def _filter(
    A: Array, B: Array, Q: Array, R: float, y: Array, u: Array, x: Array, P: Array
) -> tuple[Array, Array, Array, Array]:  # pragma: no cover - compiled
    """Filtered means and covariances, and those predicted for the sample after each."""
    n = len(y)
    mean, covariance = np.empty((n, 2)), np.empty((n, 2, 2))
    ahead, of_ahead = np.empty((n, 2)), np.empty((n, 2, 2))
    for i in range(n):
        K = P[:, 0] / (P[0, 0] + R)
        x = x + K * (y[i] - x[0])
        P = P - np.outer(K, P[0])
        P = 0.5 * (P + P.T)
        mean[i], covariance[i] = x, P
        x = A @ x + B * u[i]
        P = A @ P @ A.T + Q
        ahead[i], of_ahead[i] = x, P
    return mean, covariance, ahead, of_ahead


@njit(cache=True)
def _smoother(
    A: Array, B: Array, Q: Array, R: float, y: Array, u: Array, x: Array, P: Array
) -> tuple[Array, Array, float]:  # pragma: no cover - compiled
    """Smoothed means (N, 2), and the Q and R of largest expected likelihood by them."""
    n = len(y)
    mean, covariance, ahead, of_ahead = _filter(A, B, Q, R, y, u, x, P)
    new, noise = np.zeros((2, 2)), covariance[n - 1, 0, 0] + (y[n - 1] - mean[n - 1, 0]) ** 2
    for i in range(n - 2, -1, -1):
        G = covariance[i] @ A.T @ np.linalg.inv(of_ahead[i])
        together = covariance[i + 1] @ G.T
        mean[i] += G @ (mean[i + 1] - ahead[i])
        P = covariance[i] + G @ (covariance[i + 1] - of_ahead[i]) @ G.T
        covariance[i] = 0.5 * (P + P.T)
        w = mean[i + 1] - A @ mean[i] - B * u[i]
        cross = together @ A.T
        new += np.outer(w, w) + covariance[i + 1] - cross - cross.T + A @ covariance[i] @ A.T
        noise += covariance[i, 0, 0] + (y[i] - mean[i, 0]) ** 2
    return mean, 0.5 * (new + new.T) / (n - 1), noise / n
