"""Linear, time-invariant models of what is to be estimated, continuous and sampled.

x' = A x + B u + G w        E[w(t) w(s)^T] = W delta(t - s)
y_i = C x(t_i) + v_i        E[v_i v_i^T] = R
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from armside.arrays import Array

_SERIES = 12  # terms: 0.5^12 / 12! is far below rounding


@dataclass(frozen=True, kw_only=True, eq=False)
class Process:
    """A sampled process: x_{i+1} = A x_i + w_i, y_i = C x_i + v_i."""

    A: Array
    """(n, n)."""
    Q: Array
    """(n, n), covariance of w_i."""
    C: Array
    """(p, n)."""
    R: Array
    """(p, p), covariance of v_i."""

    def __post_init__(self) -> None:
        n, p = len(self.A), len(self.C)
        for name, shape in (("A", (n, n)), ("Q", (n, n)), ("C", (p, n)), ("R", (p, p))):
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            if value.shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {value.shape}")
            if not np.isfinite(value).all():
                raise ValueError(f"{name} holds values that are not finite")
            value.setflags(write=False)
            object.__setattr__(self, name, value)


def sampled_noise(A: Array, GWG: Array, step: float) -> tuple[Array, Array]:
    """exp(A h), and the covariance that white noise of intensity GWG leaves after h.

    A series over a short step, which is then doubled until it is h:
    Q(2 d) = Q(d) + e^{A d} Q(d) e^{A d}^T.
    """
    return _sampled_noise(
        np.ascontiguousarray(A), np.ascontiguousarray(GWG), step, _doublings(A * step)
    )


@njit(cache=True)
def _sampled_noise(
    A: Array, GWG: Array, step: float, doublings: int
) -> tuple[Array, Array]:  # pragma: no cover - compiled
    d = step / 2**doublings
    Ad, Qd = np.eye(len(A)), np.zeros_like(A)
    power, spread = np.eye(len(A)), GWG * d
    for k in range(1, _SERIES + 1):
        Qd = Qd + spread
        AX = A @ spread
        spread = (AX + AX.T) * (d / (k + 1))
        power = A @ power * (d / k)
        Ad = Ad + power
    for _ in range(doublings):
        Qd = Qd + Ad @ Qd @ np.ascontiguousarray(Ad.T)
        Ad = Ad @ Ad
    return Ad, 0.5 * (Qd + Qd.T)


def first_order_hold(A: Array, B: Array, step: float) -> tuple[Array, Array, Array]:
    """Ad, B0, B1 of x_{i+1} = Ad x_i + B0 u_i + B1 u_{i+1}: u is linear between samples."""
    n, m = B.shape
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m] = A * step, B * step
    block[n : n + m, n + m :] = np.eye(m)
    grown = exponential(block)
    B1 = grown[:n, n + m :]
    return grown[:n, :n], grown[:n, n : n + m] - B1, B1


def exponential(A: Array) -> Array:
    """e^A by scaling and squaring of its series.

    For matrices of this size it is as exact as scipy's and keeps off the threads of LAPACK, whose
    start-up costs more than the calculation where cores are shared.
    """
    doublings = _doublings(A)
    scaled = A / 2**doublings
    total = power = np.eye(len(A))
    for k in range(1, _SERIES + 1):
        power = scaled @ power / k
        total = total + power
    for _ in range(doublings):
        total = total @ total
    return total


def _doublings(A: Array) -> int:
    """How often A is to be halved until its norm is at most a half."""
    return max(0, int(np.ceil(np.log2(max(2.0 * np.abs(A).sum(axis=1).max(), 1.0)))))


def simulate(A: Array, B0: Array, B1: Array, u: Array) -> Array:
    """x (N, n) of x_{i+1} = A x_i + B0 u_i + B1 u_{i+1} from x_0 = 0."""
    forcing = np.zeros((len(u), len(A)))
    forcing[1:] = u[:-1] @ B0.T + u[1:] @ B1.T
    return _run(np.ascontiguousarray(A), forcing)


@njit(cache=True)
def _run(A: Array, forcing: Array) -> Array:  # pragma: no cover - compiled
    x = np.empty_like(forcing)
    x[0] = forcing[0]
    for i in range(1, len(forcing)):
        x[i] = A @ x[i - 1] + forcing[i]
    return x


_DOUBLINGS = 40  # 2^40 samples: a bias that wanders very slowly has settled by then
_SETTLED = 1e-10


def settled(process: Process) -> Array:
    """P, shape (n, n), of the one-step prediction error. Each doubling looks twice as far back.

    Raises:
        RuntimeError: the filter does not settle: a state is neither seen nor stable.
    """
    R_C = np.linalg.solve(process.R, process.C)
    H, steps = _doubled(np.ascontiguousarray(process.A.T), process.C.T @ R_C, process.Q)
    if steps == 0:
        raise RuntimeError("the filter does not settle: a state is neither seen nor stable")
    return H


@njit(cache=True)
def _doubled(A: Array, G: Array, H: Array) -> tuple[Array, int]:  # pragma: no cover - compiled
    """P and the doublings it took, 0 where it does not settle.

    P_{k+1} = Q + A (P_k^-1 + C^T R^-1 C)^-1 A^T from P_0 = 0, in steps of 1, 2, 4, ...
    """
    n = len(A)
    both = np.empty((n, 2 * n))
    for step in range(1, _DOUBLINGS + 1):
        both[:, :n], both[:, n:] = A, G
        solved = np.linalg.solve(np.eye(n) + G @ H, both)
        WA = np.ascontiguousarray(solved[:, :n])
        WG = np.ascontiguousarray(solved[:, n:])
        transposed = np.ascontiguousarray(A.T)
        grown = transposed @ H @ WA
        G = G + A @ WG @ transposed
        A = A @ WA
        H = H + 0.5 * (grown + grown.T)
        G = 0.5 * (G + G.T)
        if not np.isfinite(H).all():
            return H, 0
        if np.abs(grown).max() <= _SETTLED * np.abs(H).max():
            return H, step
    return H, 0
