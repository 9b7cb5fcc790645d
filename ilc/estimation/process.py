"""Linear time-invariant state-space models: sampling, simulation, steady-state covariance.

x' = A x + B u + G w        E[w(t) w(s)^T] = W delta(t - s)
y_i = C x(t_i) + v_i        E[v_i v_i^T] = R
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from armside.arrays import Array, read_only

from ..records import records

_MOST = 60
"""Most doublings of a step: |A| h of an arm is below 2^10, and precision is lost beyond 2^53."""
_SERIES = 12  # terms: 0.5^12 / 12! is far below rounding


@dataclass(frozen=True, kw_only=True, eq=False)
class Process:
    """Sampled process x_{i+1} = A x_i + w_i, y_i = C x_i + v_i, with the noise covariances Q, R.

    Shapes: A and Q (n, n), C (p, n), R (p, p).
    """

    A: Array
    Q: Array
    C: Array
    R: Array

    def __post_init__(self) -> None:
        n, p = len(self.A), len(self.C)
        for name, shape in (("A", (n, n)), ("Q", (n, n)), ("C", (p, n)), ("R", (p, p))):
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            if value.shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {value.shape}")
            if not np.isfinite(value).all():
                raise ValueError(f"{name} holds values that are not finite")
            if name in "QR" and not (np.allclose(value, value.T) and (np.diag(value) >= 0.0).all()):
                raise ValueError(f"{name} must be symmetric, with variances >= 0, got {value}")
            value.setflags(write=False)
            object.__setattr__(self, name, value)


def sampled_noise(A: Array, GWG: Array, step: float) -> tuple[Array, Array]:
    """exp(A h), and the process noise covariance of white noise with intensity GWG over h.

    A series over a short step d, doubled up to h: Q(2 d) = Q(d) + e^{A d} Q(d) e^{A d}^T.

    Raises FloatingPointError for a process that no step of h describes: |A| h above 2^_MOST.
    """
    balanced, units = _balanced(A)
    spread = np.ascontiguousarray(GWG / np.outer(units, units))
    Ad, Qd = _sampled_noise(balanced, spread, step, _doublings(balanced * step))
    return Ad * np.outer(units, 1.0 / units), Qd * np.outer(units, units)


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
    """(Ad, B0, B1) of x_{i+1} = Ad x_i + B0 u_i + B1 u_{i+1}, u linear between samples."""
    n, m = B.shape
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m] = A * step, B * step
    block[n : n + m, n + m :] = np.eye(m)
    grown = exponential(block)
    B1 = grown[:n, n + m :]
    return grown[:n, :n], grown[:n, n : n + m] - B1, B1


def exponential(A: Array) -> Array:
    """e^A by scaling and squaring of its series.

    As accurate as scipy's for small matrices, and without the threads of LAPACK, whose start-up
    costs more than the calculation on busy cores.
    """
    balanced, units = _balanced(A)
    doublings = _doublings(balanced)
    scaled = balanced / 2**doublings
    total = power = np.eye(len(A))
    for k in range(1, _SERIES + 1):
        power = scaled @ power / k
        total = total + power
    for _ in range(doublings):
        total = total @ total
    return total * np.outer(units, 1.0 / units)


def _balanced(A: Array) -> tuple[Array, Array]:
    """A in units (n,) of its states, powers of two, in which its norm is small; rounds nothing.

    Torques beside angles need twenty doublings more than the dynamics do.
    """
    from scipy.linalg import matrix_balance

    if not np.abs(A).max(initial=0.0) < 2.0**100:  # nor finite; balancing would overflow
        return np.ascontiguousarray(A), np.ones(len(A))
    balanced, (units, _) = matrix_balance(A, permute=False, separate=True)
    return np.ascontiguousarray(balanced, dtype=np.float64), units


def _doublings(A: Array) -> int:
    """Number of halvings of A until its norm is at most 1/2."""
    size = float(2.0 * np.abs(A).sum(axis=1).max())
    if np.isfinite(size) and size > 2.0**_MOST:  # one that is not finite stays so
        raise FloatingPointError(f"the process is too fast: |A| h is {size:.3g}")
    return max(0, int(np.ceil(np.log2(max(size, 1.0))))) if np.isfinite(size) else 0


@records("u")
def simulate(A: Array, B0: Array, B1: Array, u: Array) -> Array:
    """State x (N, n) of x_{i+1} = A x_i + B0 u_i + B1 u_{i+1} from x_0 = 0."""
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


_DOUBLINGS = 40  # 2^40 samples: enough for a bias with a very slow random walk
_CONVERGED = 1e-10
_VANISHED = 1e-3  # entries of a power of the filter's matrix at which it is known to be stable


def steady_state_covariance(process: Process) -> Array:
    """Steady-state covariance P (n, n) of the one-step prediction error, by a doubling algorithm.

    P is the solution that makes the filter stable. From P = 0 a recursion misses it where a state
    grows without process noise; the generalised eigenvalue problem then finds it.
    """
    try:
        R_C = np.linalg.solve(process.R, process.C)
    except np.linalg.LinAlgError:  # a reading without noise
        return _stabilising(process)
    H, steps = _doubled(read_only(process.A.T), process.C.T @ R_C, process.Q)
    return H if steps else _stabilising(process)


def _stabilising(process: Process) -> Array:
    from scipy.linalg import LinAlgError, solve_discrete_are

    A, C = process.A, process.C
    try:
        P = np.asarray(solve_discrete_are(A.T, C.T, process.Q, process.R), dtype=np.float64)
        gain = np.linalg.solve(C @ P @ C.T + process.R, C @ P @ A.T).T
        is_stable = np.abs(np.linalg.eigvals(A - gain @ C)).max() < 1.0
    except (LinAlgError, ValueError):
        is_stable, P = False, process.Q
    if not is_stable:
        raise RuntimeError(
            "the filter has no steady state: a state that is not stable is not observable or not "
            "driven by noise"
        )
    return P


@njit(cache=True)
def _doubled(A: Array, G: Array, H: Array) -> tuple[Array, int]:  # pragma: no cover - compiled
    """P and the number of doublings, 0 without convergence to a stable filter.

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
        if not (np.isfinite(H).all() and np.isfinite(A).all() and np.isfinite(G).all()):
            return H, 0
        # A is a power of the filter's matrix, which vanishes if the filter is stable.
        if np.abs(grown).max() <= _CONVERGED * np.abs(H).max() and np.abs(A).max() <= _VANISHED:
            return H, step
    return H, 0
