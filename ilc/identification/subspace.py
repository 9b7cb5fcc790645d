"""Subspace identification of several inputs and outputs, without iterations.

The column space of the observability matrix follows from a projection of future outputs on past
inputs and outputs along future inputs: PO-MOESP (Verhaegen 1994). The Kalman gain is first that
of the residuals of the states (van Overschee and De Moor, "Subspace Identification for Linear
Systems", 1996, section 4.4). B, D and the first state then minimise the one-step prediction
errors, and so does the Kalman gain (`innovations_form`).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..estimation.consistency import Whiteness, pairwise_independence, residual_test
from ..records import records
from .innovations_form import InnovationsForm, refined, states
from .polynomial import Information

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


_HORIZON = 10  # block rows: twice the order that is meant, or more
_REJECTED = 0.01  # p-value
_ROUNDING = 1e-9  # innovations relative to the output that count as none


@dataclass(frozen=True, eq=False)
class SubspaceFit:
    """Identified model, with the tests of its innovations."""

    model: InnovationsForm
    start: Array
    """(n,), state at the first sample."""
    singular_values: Array
    """Of the projection: a gap after the n-th speaks for order n."""
    n_samples: int
    feedthrough: bool
    whiteness: Whiteness | None
    """Test of the innovations; None for records too short for it, or without noise."""
    independence: float | None
    """p-value that innovations are uncorrelated with the inputs; None as above."""

    @property
    def parameters(self) -> int:
        """Independent parameters of the model: n (2 p + m), and p m of D."""
        (n, m), p = self.model.B.shape, len(self.model.C)
        return n * (2 * p + m) + (p * m if self.feedthrough else 0)

    def score(self, criterion: Information) -> float:
        """Information criterion; the smallest is best."""
        penalty = 2.0 if criterion is Information.AIC else np.log(self.n_samples)
        size = max(float(np.linalg.det(self.model.S)), np.finfo(float).tiny)
        return self.n_samples * np.log(size) + penalty * self.parameters

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to believe the model."""
        found = []
        if np.abs(self.model.poles).max() >= 1.0:
            found.append("the model is not stable: more data, or another order")
        if self.whiteness is not None and not self.whiteness.is_uncorrelated:
            found.append(
                f"the innovations are not white (p = {self.whiteness.p_value.min():.1g}): the "
                "order is too low, or the system not linear"
            )
        if self.independence is not None and self.independence < _REJECTED:
            found.append(
                f"the inputs explain part of the innovations (p = {self.independence:.1g}): the "
                "order is too low, the system not linear, or feedthrough left out"
            )
        return tuple(found)


@records("u", "y", alike=False)
def fit_subspace(
    u: Array,
    y: Array,
    sample_time: float,
    order: int,
    *,
    horizon: int = _HORIZON,
    feedthrough: bool = False,
) -> SubspaceFit:
    """Model of n = `order` states from one record; u: (N, m), y: (N, p), from any start.

    Args:
        horizon: block rows of past and future, more than order / p.
        feedthrough: fit D; 0 otherwise.
    """
    m, p = u.shape[1], y.shape[1]
    if not 1 <= order < horizon * p:
        raise ValueError(f"order must be from 1 to below {horizon * p}, got {order}")
    if len(y) < 2 * horizon * (m + p + 1) + 2 * horizon:
        raise ValueError(f"a horizon of {horizon} needs more than {len(y)} samples")
    scale_u, scale_y = (np.sqrt(np.square(s).mean(axis=0)) for s in (u, y))
    if not (scale_u.all() and scale_y.all()):
        raise ValueError("no column of u or y may be zero throughout")
    A, C, K, singular = dynamics(u / scale_u, y / scale_y, order, horizon)
    K, B, D, start = refined(A, C, K, u / scale_u, y / scale_y, feedthrough)
    scaled = InnovationsForm(A=A, B=B, C=C, D=D, K=K, S=np.eye(p), sample_time=sample_time)
    e = scaled.innovations(u / scale_u, y / scale_y, start) * scale_y
    model = InnovationsForm(
        A=A, B=B / scale_u, C=scale_y[:, None] * C, D=scale_y[:, None] * D / scale_u,
        K=K / scale_y, S=e.T @ e / len(e), sample_time=sample_time,
    )  # fmt: skip
    noisy = (e.std(axis=0) > _ROUNDING * scale_y).all()
    tests = (residual_test(e), pairwise_independence(e, u)) if noisy else (None, None)
    return SubspaceFit(model, start, singular, len(y), feedthrough, *tests)


@records("u", "y", alike=False)
def rank_subspace_orders(
    u: Array,
    y: Array,
    sample_time: float,
    orders: Iterable[int],
    criterion: Information = Information.BIC,
    *,
    horizon: int = _HORIZON,
    feedthrough: bool = False,
) -> list[SubspaceFit]:
    """Fits of all orders to one record, best first."""
    fits = [
        fit_subspace(u, y, sample_time, order, horizon=horizon, feedthrough=feedthrough)
        for order in orders
    ]
    return sorted(fits, key=lambda fit: fit.score(criterion))


@records("u")
def bootstrap_response_deviation(
    fit: SubspaceFit, u: Array, omega: ArrayLike, rng: np.random.Generator, repeats: int = 50
) -> Array:
    """Standard deviation of |response| at omega (M,) [rad/sample], (M, p, m).

    Of fits to `repeats` records that the model makes from u (N, m) and white innovations: intervals
    follow by Student's t of repeats - 1 degrees of freedom.
    """
    model, found = fit.model, []
    L = np.linalg.cholesky(model.S)
    for _ in range(repeats):
        e = rng.standard_normal((len(u), len(L))) @ L.T
        y = model.system.simulate(u) + states(model.A, e @ model.K.T) @ model.C.T + e
        again = fit_subspace(
            u, y, model.sample_time, model.order,
            horizon=max(_HORIZON, model.order + 1), feedthrough=fit.feedthrough,
        )  # fmt: skip
        found.append(np.abs(again.model.response(omega)))
    return np.std(found, axis=0, ddof=1)
