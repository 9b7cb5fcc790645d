"""Kalman filter and fixed-interval (Rauch-Tung-Striebel) smoother of a sampled linear process.

The covariances do not depend on the data: `Smoother` computes all gains once and then costs one
recursion forwards and one backwards a record. Missing samples are predicted; they are fixed when
the gains are computed.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array

from ..records import as_measured, records
from .process import Process, steady_state_covariance


@dataclass(frozen=True, eq=False)
class Filtered:
    """Innovations (N, p), measured minus predicted, NaN where the measurement is missing.

    Their covariance is (N, p, p), or (1, p, p) in steady state.
    """

    innovation: Array
    innovation_covariance: Array


@dataclass(frozen=True, eq=False)
class Smoothed(Filtered):
    """Filtered and smoothed states, (N, n)."""

    filtered: Array
    smoothed: Array


class SteadyStateFilter:
    """Kalman filter with the steady-state gain: one recursion, and the cheapest set-up."""

    def __init__(self, process: Process) -> None:
        """Raises RuntimeError if there is no steady state."""
        self.process = process
        P = steady_state_covariance(process)
        S = process.C @ P @ process.C.T + process.R
        self.innovation_covariance = 0.5 * (S + S.T)
        self.gain: Array = np.ascontiguousarray(
            np.linalg.solve(self.innovation_covariance, process.C @ P).T, dtype=np.float64
        )

    @records("y", gate=as_measured)
    def __call__(self, y: Array, start: Array | None = None) -> Filtered:
        """Innovations of y (N, p); NaN marks rows that are missing. start: (n,), 0 if None."""
        x = np.zeros(len(self.process.A)) if start is None else start.copy()
        e = _predict(self.process.A, self.process.C, self.gain, y, x)
        return Filtered(e, self.innovation_covariance[None])

    @property
    def whitening(self) -> tuple[Array, float]:
        """W with W S W^T = 1, and log det S."""
        L = np.linalg.cholesky(self.innovation_covariance)
        inverse: Array = np.asarray(np.linalg.inv(L), dtype=np.float64)
        return inverse, 2.0 * float(np.log(np.diag(L)).sum())


@dataclass(frozen=True, eq=False)
class Smoother:
    """Kalman smoother for records of N samples with the same rows missing."""

    process: Process
    start_covariance: Array
    """(n, n), covariance of the state before the first sample."""
    seen: NDArray[np.bool_]
    """(N,), False where the measurement is missing."""
    _gains: tuple[Array, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        p = self.process
        gains = _covariances(p.A, p.Q, p.C, p.R, self.start_covariance, self.seen)
        object.__setattr__(self, "_gains", gains)

    @property
    def filtered_covariance(self) -> Array:
        """(N, n, n), given the record up to each sample."""
        return self._gains[3]

    @property
    def smoothed_covariance(self) -> Array:
        """(N, n, n), given the whole record."""
        return _smoothed_covariances(self._gains[3], self._gains[4], self._gains[1])

    @records("y", gate=as_measured)
    def __call__(self, y: Array, start: Array | None = None) -> Smoothed:
        """States of y (N, p). start: (n,), expected state at the first sample, 0 if None."""
        if y.shape != (shape := (len(self.seen), len(self.process.C))):
            raise ValueError(f"y must have shape {shape}, got {y.shape}")
        gain, back, S, _, _ = self._gains
        A, C = self.process.A, self.process.C
        x = np.zeros(len(A)) if start is None else start.copy()
        e, filtered, predicted = _forwards(A, C, gain, np.ascontiguousarray(y), self.seen, x)
        return Smoothed(e, S, filtered, _backwards(filtered, predicted, back))


@njit(cache=True)
def _predict(A: Array, C: Array, K: Array, y: Array, x: Array) -> Array:  # pragma: no cover
    e = np.empty_like(y)
    for i in range(len(y)):
        e[i] = y[i] - C @ x
        if np.isfinite(e[i]).all():
            x = x + K @ e[i]
        x = A @ x
    return e


@njit(cache=True)
def _forwards(
    A: Array, C: Array, gain: Array, y: Array, seen: NDArray[np.bool_], x: Array
) -> tuple[Array, Array, Array]:  # pragma: no cover - compiled
    n_samples, n = len(y), len(A)
    e = np.full(y.shape, np.nan)
    filtered, predicted = np.empty((n_samples, n)), np.empty((n_samples, n))
    for i in range(n_samples):
        predicted[i] = x
        if seen[i]:
            e[i] = y[i] - C @ x
            x = x + gain[i] @ e[i]
        filtered[i] = x
        x = A @ x
    return e, filtered, predicted


@njit(cache=True)
def _backwards(filtered: Array, predicted: Array, back: Array) -> Array:  # pragma: no cover
    smoothed = filtered.copy()
    for i in range(len(filtered) - 2, -1, -1):
        smoothed[i] += back[i] @ (smoothed[i + 1] - predicted[i + 1])
    return smoothed


@njit(cache=True)
def _covariances(
    A: Array, Q: Array, C: Array, R: Array, P: Array, seen: NDArray[np.bool_]
) -> tuple[Array, Array, Array, Array, Array]:  # pragma: no cover - compiled
    n_samples, n, p = len(seen), len(A), len(C)
    gain, back = np.zeros((n_samples, n, p)), np.zeros((n_samples, n, n))
    S_all = np.zeros((n_samples, p, p))
    given, predicted = np.empty((n_samples, n, n)), np.empty((n_samples, n, n))
    identity = np.eye(n)
    for i in range(n_samples):
        predicted[i] = P
        if seen[i]:
            PC = P @ C.T
            S = C @ PC + R
            K = np.ascontiguousarray(np.linalg.solve(S, np.ascontiguousarray(PC.T)).T)
            # Joseph form: symmetric and positive in spite of rounding.
            I_KC = identity - K @ C
            P = I_KC @ P @ I_KC.T + K @ R @ K.T
            gain[i], S_all[i] = K, S
        given[i] = P
        P = A @ P @ A.T + Q
        P = 0.5 * (P + P.T)
        if i < n_samples - 1:
            back[i] = np.linalg.solve(P, A @ given[i]).T
    return gain, back, S_all, given, predicted


@njit(cache=True)
def _smoothed_covariances(given: Array, predicted: Array, back: Array) -> Array:  # pragma: no cover
    smoothed = given.copy()
    for i in range(len(given) - 2, -1, -1):
        change = smoothed[i + 1] - predicted[i + 1]
        smoothed[i] = given[i] + back[i] @ change @ back[i].T
    return smoothed
