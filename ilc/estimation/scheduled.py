"""Filter and smoother on a schedule: steady-state gains of the process at each sample.

For a process whose matrices change slowly, such as an arm along a way. Gains cost one steady state
a process, whatever the length of the record, and no covariance is kept for each sample.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array

from ..records import as_measured, records
from .kalman import SteadyStateFilter
from .process import Process


@dataclass(frozen=True, eq=False)
class ScheduledStates:
    """Innovations, and states of the smoother."""

    innovation: Array
    """(N, p), whitened; NaN where a reading is missing."""
    smoothed: Array
    """(N, n)."""


class ScheduledSmoother:
    """Smoother for records of N samples, with the process of each sample."""

    def __init__(self, processes: Sequence[Process], schedule: np.ndarray) -> None:
        """schedule: (N,) index among the processes."""
        filters = [SteadyStateFilter(one) for one in processes]
        self.schedule = np.ascontiguousarray(schedule, dtype=np.int64)
        self._A, self._C = np.array([f.process.A for f in filters]), filters[0].process.C
        self._gain = np.array([f.gain for f in filters])
        self._S = np.array([f.innovation_covariance for f in filters])
        self._whitening = np.array([f.whitening[0] for f in filters])
        identity = np.eye(len(self._A[0]))
        predicted = [f.predicted_covariance for f in filters]
        self._filtered = np.array(
            [(identity - f.gain @ self._C) @ P for f, P in zip(filters, predicted, strict=True)]
        )

    @property
    def smoothed_covariance(self) -> Array:
        """(S, n, n), of each process in steady state. Raises RuntimeError for one without."""
        each = zip(self._A, self._gain, self._S, self._filtered, strict=True)
        return np.array([_smoothed(A, self._C, K, S, P) for A, K, S, P in each])

    @records("y", gate=as_measured)
    def __call__(self, y: Array, start: Array) -> ScheduledStates:
        """Of readings (N, p), NaN missing, in single channels too. start: (n,), expected at first.

        A row with missing channels is used and whitened by what is known of the others.
        """
        seen = np.isfinite(y)
        (gain, S, P, whitening), which = self._with_rows(seen)
        known = self._A, self._C, gain, S, P, self.schedule, which
        e, smoothed = _smooth(*known, y, start.copy())
        white = np.einsum("nij,nj->ni", whitening[which], np.where(seen, e, 0.0))
        return ScheduledStates(np.where(seen, white, np.nan), smoothed)

    def _with_rows(self, seen: NDArray[np.bool_]) -> tuple[list[Array], NDArray[np.int64]]:
        """Gains, S, covariances and whitening of each process, then of each row (N, p) that misses
        some channels; and the index (N,) among them. S is the identity in missing channels.
        """
        known = self._gain, self._S, self._filtered, self._whitening
        more, which = [[] for _ in known], self.schedule.copy()
        for i in np.flatnonzero(seen.any(axis=1) & ~seen.all(axis=1)):
            which[i] = len(known[0]) + len(more[0])
            for rows, one in zip(more, self._without(self.schedule[i], ~seen[i]), strict=True):
                rows.append(one)
        return [np.array([*all_, *rows]) for all_, rows in zip(known, more, strict=True)], which

    def _without(self, s: int, missing: NDArray[np.bool_]) -> tuple[Array, Array, Array, Array]:
        """Of process s without some channels: K = P C^T S^-1 gives P C^T = K S."""
        K, S, P = self._gain[s], self._S[s].copy(), self._filtered[s]
        PC, predicted = K @ S, P + K @ S @ K.T
        PC[:, missing], S[missing], S[:, missing] = 0.0, 0.0, 0.0
        S[missing, missing] = 1.0
        gain = np.linalg.solve(S, PC.T).T
        whitening: Array = np.asarray(np.linalg.inv(np.linalg.cholesky(S)), dtype=np.float64)
        return gain, S, predicted - gain @ PC.T, whitening


_LONGEST = 4000
"""Samples after which information of later readings has come to a steady state."""


def _smoothed(A: Array, C: Array, K: Array, S: Array, P: Array) -> Array:
    blind, information = np.eye(len(A)) - K @ C, C.T @ np.linalg.solve(S, C)
    M = np.zeros_like(A)
    for _ in range(_LONGEST):
        following = A.T @ (information + blind.T @ M @ blind) @ A
        done = np.abs(following - M).max() <= 1e-6 * np.abs(following).max()
        M = 0.5 * (following + following.T)
        if done:
            return P - P @ M @ P
    raise RuntimeError(f"the smoother has no steady state within {_LONGEST} samples")


@njit(cache=True)
def _smooth(
    A: Array,
    C: Array,
    gain: Array,
    S: Array,
    covariance: Array,
    schedule: np.ndarray,
    which: np.ndarray,
    y: Array,
    x: Array,
) -> tuple[Array, Array]:  # pragma: no cover - compiled
    n_samples, n = len(y), len(x)
    e, filtered, smoothed = np.empty_like(y), np.empty((n_samples, n)), np.empty((n_samples, n))
    for i in range(n_samples):
        e[i] = y[i] - C @ x
        if np.isfinite(e[i]).any():
            x = x + gain[which[i]] @ np.where(np.isnan(e[i]), 0.0, e[i])
        filtered[i] = x
        x = A[schedule[i]] @ x
    ahead = np.zeros(n)  # A^T r_{i+1}, as in `kalman.Smoother`
    for i in range(n_samples - 1, -1, -1):
        k = which[i]
        smoothed[i] = filtered[i] + covariance[k] @ ahead
        r = ahead
        if np.isfinite(e[i]).any():
            left = np.where(np.isnan(e[i]), 0.0, e[i])
            r = C.T @ np.linalg.solve(S[k], left) + ahead - C.T @ (gain[k].T @ ahead)
        ahead = r @ A[schedule[i]]
    return e, smoothed
