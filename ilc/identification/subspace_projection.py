"""Dynamics of a subspace fit: the projection of the future on the past, and the Kalman gain.

PO-MOESP (Verhaegen 1994); the gain from the residuals of the states (van Overschee and De Moor,
"Subspace Identification for Linear Systems", 1996, section 4.4).
"""

import numpy as np

from armside.arrays import Array

from ..records import records

_FLOOR = 1e-9  # variance of the outputs' noise at least, relative to the one found


def _hankel(signal: Array, first: int, rows: int, columns: int) -> Array:
    """Block rows (rows * width, columns) of samples from `first` on."""
    return np.concatenate([signal[first + i : first + i + columns].T for i in range(rows)])


@records("u", "y", alike=False)
def dynamics(u: Array, y: Array, n: int, i: int) -> tuple[Array, Array, Array, Array]:
    """A (n, n), C, K and the singular values of the projection, with i block rows."""
    (N, m), p = u.shape, y.shape[1]
    columns = N - 2 * i + 1
    blocks = [_hankel(u, i, i, columns), _hankel(u, 0, i, columns), _hankel(y, 0, i, columns)]
    data = np.concatenate([*blocks, _hankel(y, i, i, columns)]) / np.sqrt(columns)
    R = np.asarray(np.linalg.qr(data.T, mode="r"), dtype=np.float64).T
    future, past = i * m, i * (m + p)
    projected = R[future + past :, future : future + past]  # future outputs on the past
    U, singular, _ = np.linalg.svd(projected, full_matrices=False)
    G = U[:, :n] * np.sqrt(singular[:n])  # observability matrix
    A, C = np.linalg.lstsq(G[:-p], G[p:], rcond=None)[0], G[:p]
    return A, C, _gain(A, C, G, R, data, (m, p, i)), singular


def _gain(
    A: Array, C: Array, G: Array, R: Array, data: Array, sizes: tuple[int, int, int]
) -> Array:
    """Kalman gain from the residuals of the states, themselves projections on the past."""
    m, p, i = sizes
    future, past = i * m, i * (m + p)
    by_past = np.linalg.lstsq(
        R[future : future + past, future : future + past].T,
        R[future + past :, future : future + past].T,
        rcond=1e-12,
    )[0].T
    x = np.linalg.lstsq(G, by_past @ data[future : future + past], rcond=None)[0]
    inputs = data[:(m)]
    now = np.concatenate((x[:, :-1], inputs[:, :-1]))
    output = data[future + past : future + past + p, :-1]
    target = np.concatenate((x[:, 1:], output))
    left = target - np.linalg.lstsq(now.T, target.T, rcond=None)[0].T @ now
    return _steady_gain(A, C, left @ left.T)


def _steady_gain(A: Array, C: Array, covariance: Array) -> Array:
    from scipy.linalg import LinAlgError, solve_discrete_are

    n, p = len(A), len(C)
    Q, S, R = covariance[:n, :n], covariance[:n, n:], covariance[n:, n:]
    size = max(float(np.trace(R)), 1e-12)
    R = R + _FLOOR * size * np.eye(p)
    try:
        P = solve_discrete_are(A.T, C.T, Q, R, s=S)
        K = np.linalg.solve(C @ P @ C.T + R, (A @ P @ C.T + S).T).T
    except (LinAlgError, ValueError):
        return np.zeros((n, p))
    stable = np.abs(np.linalg.eigvals(A - K @ C)).max() < 1.0
    return np.asarray(K, dtype=np.float64) if stable else np.zeros((n, p))
