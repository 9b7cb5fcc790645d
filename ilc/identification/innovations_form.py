"""State-space model in innovations form, its fit for given dynamics, and what a fit says.

x_{i+1} = A x_i + B u_i + K e_i        y_i = C x_i + D u_i + e_i        E[e e^T] = S

For given A and C the matrices B, D, the first state and the Kalman gain K minimise the one-step
prediction errors: B, D and the first state by linear least squares for a gain, the gain by
Gauss-Newton, for the projection of `subspace` sees only as far back as its horizon.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.state_space import StateSpace
from ..models.system import Complex
from ..records import records


@dataclass(frozen=True, kw_only=True, eq=False)
class InnovationsForm:
    """Shapes: A (n, n), B (n, m), C (p, n), D (p, m), K (n, p), S (p, p)."""

    A: Array
    B: Array
    C: Array
    D: Array
    K: Array
    S: Array
    sample_time: float
    """[s]."""

    @cached_property
    def system(self) -> StateSpace:
        """From u to y, as laws and analysis take it."""
        return StateSpace(self.A, self.B, self.C, self.D, self.sample_time)

    @property
    def order(self) -> int:
        return len(self.A)

    @property
    def poles(self) -> Complex:
        return np.linalg.eigvals(self.A).astype(np.complex128)

    def response(self, omega: ArrayLike) -> Complex:
        """From u to y, (M, p, m), at omega (M,) [rad/sample]."""
        return self.system.response(omega)

    @records("u", "y", alike=False)
    def innovations(self, u: Array, y: Array, start: ArrayLike | None = None) -> Array:
        """One-step prediction errors e (N, p) from `start` (n,), 0 if None."""
        x = np.zeros(self.order) if start is None else np.asarray(start, dtype=np.float64)
        forcing = u @ (self.B - self.K @ self.D).T + y @ self.K.T
        x = states(self.A - self.K @ self.C, forcing, x)
        return y - x @ self.C.T - u @ self.D.T


@records("forcing")
def states(A: Array, forcing: Array, start: Array | None = None) -> Array:
    """x (N, n) of x_{i+1} = A x_i + forcing_i."""
    first = np.zeros(len(A)) if start is None else start
    return _states(np.ascontiguousarray(A), np.ascontiguousarray(forcing), first.copy())


@njit(cache=True)
def _states(A: Array, forcing: Array, x: Array) -> Array:  # pragma: no cover - compiled
    found = np.empty_like(forcing)
    for i in range(len(forcing)):
        found[i] = x
        x = A @ x + forcing[i]
    return found


_STEPS = 6
_CONVERGED = 1e-5  # relative decrease of the sum of squares
_HALVINGS = 6


@records("u", "y", alike=False)
def refined(
    A: Array, C: Array, K: Array, u: Array, y: Array, feedthrough: bool
) -> tuple[Array, Array, Array, Array]:
    """Gain K (n, p), B (n, m), D (p, m) and first state (n,); u: (N, m), y: (N, p)."""
    columns, theta, e = _linear(A, C, K, u, y, feedthrough)
    for _ in range(_STEPS):
        found = _next_gain(A, C, K, columns, e, u, y, feedthrough)
        if found is None:
            break
        gained = 1.0 - np.square(found[3]).sum() / np.square(e).sum()
        K, columns, theta, e = found
        if gained < _CONVERGED:
            break
    return K, *_split(theta, len(A), u.shape[1], len(C), feedthrough)


def _next_gain(
    A: Array, C: Array, K: Array, columns: Array, e: Array, u: Array, y: Array, feedthrough: bool
) -> tuple[Array, Array, Array, Array] | None:
    """K, columns, theta and e after a Gauss-Newton step in the gain; None without a decrease."""
    size = np.abs(y).max()
    if np.abs(e).max() < 1e-10 * size:  # no noise, no gain
        return None
    blind = A - K @ C
    by_gain = [
        states(blind, np.outer(e[:, k], unit)) @ C.T
        for unit in np.eye(len(A))
        for k in range(len(C))
    ]
    both = np.column_stack((columns, *(column.ravel() for column in by_gain)))
    step = np.linalg.lstsq(both, e.ravel(), rcond=None)[0][columns.shape[1] :].reshape(K.shape)
    for _ in range(_HALVINGS):
        tried = K + step
        if np.abs(np.linalg.eigvals(A - tried @ C)).max() < 1.0:
            found = _linear(A, C, tried, u, y, feedthrough)
            if np.square(found[2]).sum() < np.square(e).sum():
                return tried, *found
        step = 0.5 * step
    return None


def _linear(
    A: Array, C: Array, K: Array, u: Array, y: Array, feedthrough: bool
) -> tuple[Array, Array, Array]:
    """Regressor (N p, ...), coefficients of B, D and first state, and prediction errors (N, p)."""
    n, m, p = len(A), u.shape[1], len(C)
    blind = A - K @ C

    def seen(forcing: Array, start: Array | None = None) -> Array:
        return states(blind, forcing, start) @ C.T

    columns = [seen(np.outer(u[:, j], unit)) for j in range(m) for unit in np.eye(n)]
    for j in range(m if feedthrough else 0):
        for k, unit in enumerate(np.eye(p)):
            columns.append(np.outer(u[:, j], unit) - seen(np.outer(u[:, j], K[:, k])))
    columns += [seen(np.zeros((len(u), n)), unit) for unit in np.eye(n)]
    regressor = np.stack([column.ravel() for column in columns], axis=1)
    target = (y - seen(y @ K.T)).ravel()
    theta = _excited(regressor, target, n)
    return regressor, theta, (target - regressor @ theta).reshape(y.shape)


def _excited(regressor: Array, target: Array, n: int) -> Array:
    """Least squares. ValueError where the inputs' part, all but the last n, is not determined."""
    size = np.sqrt(np.square(regressor).sum(axis=0))
    if np.linalg.matrix_rank((regressor / size)[:, :-n]) < regressor.shape[1] - n:
        raise ValueError("the data do not excite all inputs")
    return np.asarray(np.linalg.lstsq(regressor, target, rcond=None)[0], dtype=np.float64)


def _split(theta: Array, n: int, m: int, p: int, feedthrough: bool) -> tuple[Array, Array, Array]:
    B, D, start = np.split(theta, [n * m, len(theta) - n])
    return B.reshape(m, n).T, D.reshape(m, p).T if feedthrough else np.zeros((p, m)), start
