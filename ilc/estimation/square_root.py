"""Square-root Kalman filter and fixed-interval smoother, for records that are stiff.

Covariances are kept as factors, P = S S^T, and updated by orthogonal transformations: no variance
can become negative, nor vanish in the difference P - P M P. The filter is the array form (Kailath,
Sayed and Hassibi, "Linear Estimation", section 12.3); the smoother joins it with the square root of
the information of all later readings (Fraser and Potter 1969). States known exactly, states without
process noise and single channels missing are allowed; each reading needs noise.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..records import as_measured, records
from .kalman import Filtered
from .process import Process


@dataclass(frozen=True, eq=False)
class SquareRootSmoothed(Filtered):
    """States (N, n), and factors (N, n, n) of their covariances S S^T."""

    filtered: Array
    filtered_factor: Array
    smoothed: Array
    smoothed_factor: Array

    @property
    def filtered_covariance(self) -> Array:
        """(N, n, n), given the record up to each sample."""
        return self.filtered_factor @ np.swapaxes(self.filtered_factor, 1, 2)

    @property
    def smoothed_covariance(self) -> Array:
        """(N, n, n), given the whole record."""
        return self.smoothed_factor @ np.swapaxes(self.smoothed_factor, 1, 2)


class _Seen(NamedTuple):
    """What one row of a record measures: e = y - C x, in units of its noise."""

    channels: np.ndarray
    C: Array
    """(k, n)."""
    y: Array
    noise: Array
    """(k, k), lower triangular: physical units of one whitened unit."""


@records("y", gate=as_measured)
def smooth_square_root(
    process: Process, y: Array, start: Array, start_factor: Array
) -> SquareRootSmoothed:
    """Filter and smoother of y (N, p), NaN where a reading is missing.

    Args:
        start: (n,), expected state at the first sample.
        start_factor: (n, n), S of its covariance S S^T; zero rows for what is known exactly.

    Raises:
        ValueError: for a reading without noise, or shapes that do not fit.
    """
    n, p = len(process.A), len(process.C)
    if y.shape[1] != p or start.shape != (n,) or start_factor.shape != (n, n):
        given = f"{y.shape}, {start.shape} and {start_factor.shape}"
        raise ValueError(f"y, start and start_factor must fit {p} readings, {n} states: {given}")
    if not np.linalg.eigvalsh(process.R)[0] > 0.0:
        raise ValueError("R must be positive definite: a reading without noise has no square root")
    rows = [_seen(process, row) for row in y]
    e, covariance, x, S = _forwards(process, rows, y.shape, start, start_factor)
    smoothed, factor = _backwards(process, rows, x, S)
    return SquareRootSmoothed(e, covariance, x, S, smoothed, factor)


def _seen(process: Process, row: Array) -> _Seen:
    from scipy.linalg import solve_triangular

    channels = np.flatnonzero(np.isfinite(row))
    noise = _factor(process.R[np.ix_(channels, channels)])
    C = solve_triangular(noise, process.C[channels], lower=True)
    return _Seen(channels, C, solve_triangular(noise, row[channels], lower=True), noise)


def _forwards(
    process: Process, rows: list[_Seen], shape: tuple[int, ...], x: Array, S: Array
) -> tuple[Array, Array, Array, Array]:
    """Innovations, their covariances, states and factors."""
    from scipy.linalg import solve_triangular

    n, (N, p), G = len(x), shape, _factor(process.Q)
    e, covariance = np.full((N, p), np.nan), np.tile(np.eye(p), (N, 1, 1))
    states, factors = np.empty((N, n)), np.empty((N, n, n))
    for i, (channels, C, reading, noise) in enumerate(rows):
        k = len(channels)
        before = np.zeros((k + n, k + n))
        before[:k, :k], before[:k, k:], before[k:, k:] = np.eye(k), C @ S, S
        after = _triangular(before)
        left = reading - C @ x
        e[i, channels] = noise @ left
        root = noise @ after[:k, :k]
        covariance[i][np.ix_(channels, channels)] = root @ root.T
        states[i] = x + after[k:, :k] @ solve_triangular(after[:k, :k], left, lower=True)
        factors[i] = after[k:, k:]
        x, S = process.A @ states[i], _triangular(np.hstack((process.A @ factors[i], G)))
    return e, covariance, states, factors


def _backwards(process: Process, rows: list[_Seen], x: Array, S: Array) -> tuple[Array, Array]:
    """Smoothed states and factors; later readings are rows L^T x = about, in white noise."""
    from scipy.linalg import solve_triangular

    A, G = process.A, _factor(process.Q)
    n = len(A)
    L, about = np.zeros((n, n)), np.zeros(n)
    smoothed, factors = np.empty_like(x), np.empty_like(S)
    for i in range(len(x) - 1, -1, -1):
        M = S[i].T @ L
        W = _triangular(np.hstack((np.eye(n), M)))  # W W^T = I + M M^T
        factors[i] = solve_triangular(W, S[i].T, lower=True).T
        smoothed[i] = x[i] + factors[i] @ (factors[i].T @ (L @ (about - L.T @ x[i])))
        _, C, reading, _ = rows[i]
        # L^T x = about + white noise, joined with C x = reading + white noise
        U, eta = _joined(np.vstack((L.T, C)), np.append(about, reading))
        V = U.T @ G
        W = _triangular(np.hstack((np.eye(n), V)))
        L = A.T @ solve_triangular(W, U.T, lower=True).T
        about = solve_triangular(W, eta, lower=True)
    return smoothed, factors


def _joined(H: Array, z: Array) -> tuple[Array, Array]:
    """(U, eta) of n rows U^T x = eta with the information of H x = z, both in white noise."""
    n = H.shape[1]
    Q, R = np.linalg.qr(H)
    return np.asarray(R, dtype=np.float64).T[:, :n], np.asarray(Q.T @ z, dtype=np.float64)


def _triangular(M: Array) -> Array:
    """Lower triangular T with T T^T = M M^T."""
    return np.asarray(np.linalg.qr(M.T, mode="r"), dtype=np.float64).T


def _factor(covariance: Array) -> Array:
    """S with S S^T the covariance, which may be singular."""
    try:
        return np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(covariance)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)), dtype=np.float64)
