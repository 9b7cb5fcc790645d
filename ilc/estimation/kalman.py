"""Kalman filter and fixed-interval smoother of a sampled linear process.

The covariances do not depend on the data: `Smoother` computes all gains once and then costs one
recursion forwards and one backwards a record. Missing measurements are fixed when the gains are
computed. The recursion backwards is that of de Jong, "Smoothing and interpolation with the
state-space model" (1989), which inverts no covariance of a state: states may be known exactly.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple
from warnings import warn

import numpy as np
from numba import njit
from numpy.typing import NDArray

from armside.arrays import Array, read_only

from ..models.system import Complex
from ..records import as_measured, records
from .process import Process, steady_state_covariance

_AMPLIFIED = 5e5  # of rounding of P in one update, from which smoothed variances may be lost
_SOLVED = 1e-6  # relative: a step of Newton's method leaves more
_TOO_FAR_APART = (
    "variances of states and readings are too far apart for Smoother: its variances may be wrong, "
    "even negative, and then its means"
)


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

    def __init__(self, process: Process, covariance: Array | None = None) -> None:
        """covariance: (n, n) of the one-step prediction error, where it is known.

        Raises RuntimeError if there is no steady state.
        """
        self.process = process
        P = steady_state_covariance(process) if covariance is None else covariance
        self.predicted_covariance = P
        S = process.C @ P @ process.C.T + process.R
        self.innovation_covariance = 0.5 * (S + S.T)
        self.gain: Array = np.ascontiguousarray(
            np.linalg.solve(self.innovation_covariance, process.C @ P).T, dtype=np.float64
        )

    @records("y", gate=as_measured)
    def __call__(self, y: Array, start: Array | None = None) -> Filtered:
        """Innovations of y (N, p); NaN marks what is missing. start: (n,), 0 if None.

        Rows with missing channels are used with the gain that P gives for the others.
        """
        x = np.zeros(len(self.process.A)) if start is None else start.copy()
        e = _predict(self.process.A, self.process.C, self.gain, self.innovation_covariance, y, x)
        return Filtered(e, self.innovation_covariance[None])

    def beside(self, process: Process) -> "SteadyStateFilter":
        """Filter of a process that differs little, as in a difference quotient.

        One step of Newton's method for the Riccati equation, which leaves the square of the
        change: P + X with X - F X F^T what P leaves of the equation, F of this filter. Where the
        modes of F do not solve that, the whole equation of the process is solved.

        Raises RuntimeError if that is so, and there is no steady state.
        """
        try:
            with np.errstate(all="ignore"):
                found = SteadyStateFilter(process, self.predicted_covariance + self._step(process))
            np.linalg.cholesky(found.innovation_covariance)
        except np.linalg.LinAlgError:
            return SteadyStateFilter(process)
        return found

    def _step(self, process: Process) -> Array:
        """X (n, n). Raises LinAlgError where F has no modes, or they are too near to each other."""
        P, A, C, units = self.predicted_covariance, process.A, process.C, self._units
        gain = np.linalg.solve(C @ P @ C.T + process.R, C @ P)
        left = A @ (P - P @ C.T @ gain) @ A.T + process.Q - P
        F, (values, vectors, inverse) = self._recursion, self._modes
        left = left / np.outer(units, units)
        X = inverse @ left @ inverse.T / (1.0 - np.outer(values, values))
        X = (vectors @ X @ vectors.T).real
        if not np.abs(X - F @ X @ F.T - left).max() <= _SOLVED * np.abs(left).max():  # NaN too
            raise np.linalg.LinAlgError("modes do not solve the equation of the filter beside")
        return np.asarray(X * np.outer(units, units), dtype=np.float64)

    @cached_property
    def _units(self) -> Array:
        """(n,), of the states."""
        sd = np.sqrt(np.diag(self.predicted_covariance))
        return np.where(sd > 0.0, sd, 1.0)

    @cached_property
    def _recursion(self) -> Array:
        """F (n, n) of the prediction error, in those units."""
        one, units = self.process, self._units
        return (one.A - one.A @ self.gain @ one.C) * units / units[:, None]

    @cached_property
    def _modes(self) -> tuple[Complex, Complex, Complex]:
        """Eigenvalues (n,) of F, eigenvectors, their inverse."""
        values, vectors = np.linalg.eig(self._recursion.astype(np.complex128))
        inverse: Complex = np.asarray(np.linalg.inv(vectors), dtype=np.complex128)
        return values, vectors, inverse

    @property
    def whitening(self) -> tuple[Array, Array]:
        """W = L^-1 with L L^T = S, and the terms 2 log L_ii of log det S, (p,)."""
        L = np.linalg.cholesky(self.innovation_covariance)
        inverse: Array = np.asarray(np.linalg.inv(L), dtype=np.float64)
        return inverse, 2.0 * np.log(np.diag(L))


@dataclass(frozen=True, eq=False)
class Smoother:
    """Kalman smoother for records of N samples with the same measurements missing.

    The covariances are differences: where variances of states and readings are some 1e12 apart,
    rounding may leave nothing of them. A RuntimeWarning says so, unless a reading has no noise.
    """

    process: Process
    start_covariance: Array
    """(n, n), covariance of the state before the first sample; 0 for what is known exactly."""
    seen: NDArray[np.bool_]
    """(N,), or (N, p) for single channels; False where a measurement is missing."""
    _gains: "_Gains" = field(init=False, repr=False)

    def __post_init__(self) -> None:
        one, n, p = self.process, len(self.process.A), len(self.process.C)
        seen = np.asarray(self.seen, dtype=bool)
        if seen.ndim not in (1, 2) or seen.shape[1:] not in ((), (p,)):
            raise ValueError(f"seen must have shape (N,) or (N, {p}), got {seen.shape}")
        start = read_only(np.asarray(self.start_covariance, dtype=np.float64))
        if start.shape != (n, n):
            raise ValueError(f"start_covariance must have shape {(n, n)}, got {start.shape}")
        rows = seen[:, None] if seen.ndim == 1 else seen
        channels = read_only(np.broadcast_to(rows, (len(seen), p)))
        *found, amplified = _covariances(one.A, one.Q, one.C, one.R, start, channels)
        if amplified > _AMPLIFIED and np.diagonal(one.R).all():
            warn(_TOO_FAR_APART, RuntimeWarning, stacklevel=3)
        object.__setattr__(self, "_gains", _Gains(channels, *found))

    @property
    def filtered_covariance(self) -> Array:
        """(N, n, n), given the record up to each sample."""
        return self._gains.filtered

    @property
    def smoothed_covariance(self) -> Array:
        """(N, n, n), given the whole record."""
        known = self._gains
        return _smoothed_covariances(
            self.process.A, self.process.C, known.blind, known.weight, known.filtered
        )

    @records("y", gate=as_measured)
    def __call__(self, y: Array, start: Array | None = None) -> Smoothed:
        """States of y (N, p). start: (n,), expected state at the first sample, 0 if None."""
        known = self._gains
        if y.shape != known.seen.shape:
            raise ValueError(f"y must have shape {known.seen.shape}, got {y.shape}")
        if (lost := np.argwhere(known.seen & np.isnan(y))).size:
            raise ValueError(f"y is missing at sample {lost[0, 0]}, channel {lost[0, 1]}: see seen")
        A, C = self.process.A, self.process.C
        x = np.zeros(len(A)) if start is None else start.copy()
        e, filtered = _forwards(A, C, known.gain, np.ascontiguousarray(y), known.seen, x)
        smoothed = _backwards(A, known.blind, known.weight, known.filtered, e, filtered)
        return Smoothed(e, known.S, filtered, smoothed)


class _Gains(NamedTuple):
    """Everything that does not depend on the data, by sample."""

    seen: NDArray[np.bool_]
    gain: Array
    """K, (N, n, p), 0 in columns of missing channels."""
    blind: Array
    """I - K C, (N, n, n)."""
    weight: Array
    """C^T S^-1, (N, n, p), 0 in columns of missing channels."""
    S: Array
    """(N, p, p), the identity in missing channels."""
    filtered: Array
    """Covariance, (N, n, n)."""


@njit(cache=True)
def _predict(
    A: Array, C: Array, K: Array, S: Array, y: Array, x: Array
) -> Array:  # pragma: no cover - compiled
    e = np.empty_like(y)
    for i in range(len(y)):
        e[i] = y[i] - C @ x
        seen = np.isfinite(e[i])
        if seen.all():
            x = x + K @ e[i]
        elif seen.any():  # the most likely value of the missing innovations is S_ms S_ss^-1 e_s
            there, missing = np.flatnonzero(seen), np.flatnonzero(~seen)
            given = np.linalg.solve(S[there][:, there], e[i][there])
            filled = np.zeros(len(seen))
            filled[there] = e[i][there]
            filled[missing] = S[missing][:, there] @ given
            x = x + K @ filled
        x = A @ x
    return e


@njit(cache=True)
def _forwards(
    A: Array, C: Array, gain: Array, y: Array, seen: NDArray[np.bool_], x: Array
) -> tuple[Array, Array]:  # pragma: no cover - compiled
    e, filtered = np.empty_like(y), np.empty((len(y), len(A)))
    for i in range(len(y)):
        left = np.where(seen[i], y[i] - C @ x, 0.0)
        e[i] = np.where(seen[i], left, np.nan)
        filtered[i] = x + gain[i] @ left
        x = A @ filtered[i]
    return e, filtered


@njit(cache=True)
def _backwards(
    A: Array, blind: Array, weight: Array, covariance: Array, e: Array, filtered: Array
) -> Array:  # pragma: no cover - compiled
    """x + P A^T r_{i+1} with r_i = C^T S^-1 e_i + (I - K C)^T A^T r_{i+1}."""
    smoothed = np.empty_like(filtered)
    ahead = np.zeros(len(A))  # A^T r_{i+1}
    for i in range(len(e) - 1, -1, -1):
        smoothed[i] = filtered[i] + covariance[i] @ ahead
        left = np.where(np.isnan(e[i]), 0.0, e[i])
        ahead = (weight[i] @ left + ahead @ blind[i]) @ A
    return smoothed


@njit(cache=True)
def _covariances(
    A: Array, Q: Array, C: Array, R: Array, P: Array, seen: NDArray[np.bool_]
) -> tuple[Array, Array, Array, Array, Array, float]:  # pragma: no cover - compiled
    """The fields of `_Gains` after `seen`, and how much an update amplifies rounding of P."""
    n_samples, n, p = len(seen), len(A), len(C)
    gain, weight = np.zeros((n_samples, n, p)), np.zeros((n_samples, n, p))
    blind, S_all = np.empty((n_samples, n, n)), np.empty((n_samples, p, p))
    filtered, identity, amplified = np.empty((n_samples, n, n)), np.eye(n), 1.0
    for i in range(n_samples):
        # A missing channel measures nothing, with noise of unit variance.
        Ci, Ri = C.copy(), R.copy()
        for c in np.flatnonzero(~seen[i]):
            Ci[c], Ri[c], Ri[:, c] = 0.0, 0.0, 0.0
            Ri[c, c] = 1.0
        PC = P @ Ci.T
        S = Ci @ PC + Ri
        K = np.ascontiguousarray(np.linalg.solve(S, np.ascontiguousarray(PC.T)).T)
        # Joseph form: symmetric and positive in spite of rounding.
        I_KC = identity - K @ Ci
        deviation = np.sqrt(np.maximum(np.diag(P), 0.0))
        size = deviation + np.abs(K) @ (np.abs(Ci) @ deviation)  # of the terms of I - K C
        lost = size * (np.abs(I_KC) @ deviation)
        P = I_KC @ P @ I_KC.T + K @ Ri @ K.T
        for j in range(n):
            if lost[j] > amplified * P[j, j]:
                amplified = lost[j] / P[j, j] if P[j, j] > 0.0 else np.inf
        gain[i], blind[i], S_all[i], filtered[i] = K, I_KC, S, P
        weight[i] = np.linalg.solve(S, Ci).T
        P = A @ P @ A.T + Q
        P = 0.5 * (P + P.T)
    return gain, blind, weight, S_all, filtered, amplified


@njit(cache=True)
def _smoothed_covariances(
    A: Array, C: Array, blind: Array, weight: Array, filtered: Array
) -> Array:  # pragma: no cover - compiled
    """P - P M P with M = A^T N_{i+1} A, N_i = C^T S^-1 C + (I - K C)^T M (I - K C)."""
    smoothed = np.empty_like(filtered)
    M = np.zeros_like(A)
    for i in range(len(filtered) - 1, -1, -1):
        smoothed[i] = filtered[i] - filtered[i] @ M @ filtered[i]
        # Columns of missing channels of the weight are 0.
        N = weight[i] @ C + blind[i].T @ M @ blind[i]
        M = A.T @ (0.5 * (N + N.T)) @ A
    return smoothed
