"""Output-error identification of a first-order lag with delay: y = b / (1 - a q^-1) u(t - n_k).

The error of the simulation is minimised. ARX minimises the one-step prediction error, which
prefers slow poles for smooth records under friction. Thesis (9.11), (9.12). The fit of a model is
defined here once: 1 - ||y - y_sim|| / ||y - mean(y)||.

Learning data are sums over experiments of u_K and of y_K - y_0: friction does not depend on the
correction, so a sum over several speeds averages it. At rest it holds a motor in place, which is
no linear dynamics: records end with the first motion that ends.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..estimation.consistency import Whiteness, residual_test
from ..filters import recursion
from ..models.state_space import StateSpace
from ..models.system import System
from ..records import as_record, records
from .polynomial import delayed

_TOLERANCE = 1e-4  # of the pole that the search ends at
_SLOWEST = 0.98  # pole; a slower one resembles an integrator in records of a second


@dataclass(frozen=True, eq=False)
class FirstOrderModel:
    """Identified T_u(q) = b q^-delay / (1 - pole q^-1)."""

    system: System
    delay: int
    """[samples]."""
    pole: float
    fit: float
    """Of all experiments together."""
    covariance: Array
    """(2, 2) of (b, pole) at the delay found, for white noise on the output."""
    whiteness: Whiteness | None
    """Test of the simulation error; None for records too short for it."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to believe the pole or its uncertainty."""
        found = []
        if not _TOLERANCE < self.pole < _SLOWEST - _TOLERANCE:
            found.append(
                f"the pole is at the end of the search from 0 to {_SLOWEST}: the system is slower "
                "or oscillates from sample to sample"
            )
        if self.whiteness is not None and not self.whiteness.is_uncorrelated:
            found.append(
                f"the simulation error is not white (p = {self.whiteness.p_value.min():.1g}): "
                "intervals are too narrow"
            )
        return tuple(found)

    def confidence(self, sigmas: float = 1.96) -> Array:
        """(2, 2), confidence intervals of b and the pole; 1.96 standard errors are 95 %."""
        centre = np.array([self.system.b[self.delay], self.pole])
        width = sigmas * np.sqrt(np.diag(self.covariance))
        return np.column_stack((centre - width, centre + width))

    @property
    def static_gain(self) -> float:
        return self.system.static_gain

    @property
    def total_delay(self) -> float:
        """Delay and lag, delay + pole / (1 - pole) [samples]."""
        return self.delay + self.pole / (1.0 - self.pole)


@records("u", "y")
def fit_first_order(
    u: Array, y: Array, sample_time: float, *, delays: Iterable[int] = range(11)
) -> FirstOrderModel:
    """Least squares of the simulation error; u, y: shape (N, m), m experiments from rest.

    For each delay the pole is searched in [0, 0.98]; the gain follows in closed form.
    """
    from scipy.optimize import minimize_scalar

    if not u.any() or not y.any():
        raise ValueError("u and y must not be zero throughout")

    def squared_error(pole: float, delay: int) -> float:
        gain, x = _best_gain(u, y, delay, pole)
        return float(np.square(y - gain * x).sum())

    found, bounds = [], (0.0, _SLOWEST)
    for delay in delays:
        search = minimize_scalar(squared_error, args=(delay,), bounds=bounds, method="bounded")
        inside = float(search.x)  # type: ignore[attr-defined]
        found += [(squared_error(pole, delay), delay, pole) for pole in (inside, *bounds)]
    if not found:
        raise ValueError("delays must not be empty")
    error, delay, pole = min(found, key=lambda each: each[0])
    gain, _ = _best_gain(u, y, delay, pole)
    system = System(np.append(np.zeros(delay), gain), np.array([1.0, -pole]), sample_time)
    fit = 1.0 - np.sqrt(error / np.square(y - y.mean(axis=0)).sum())
    left = y - system.simulate(u)
    covariance = _covariance(u, gain, pole, delay, error / max(y.size - 2, 1))
    return FirstOrderModel(system, delay, pole, fit, covariance, residual_test(left))


@records("u", "y", alike=False)
def fit_of(system: System | StateSpace, u: Array, y: Array) -> float:
    """Fit of a model's simulation from rest to (u, y), (N, m) and (N, p), all columns together."""
    return float(_fit(system, u, y, None))


@records("u", "y")
def fit_of_each(system: System, u: Array, y: Array) -> Array:
    """Fit of a model's simulation to each of m experiments, shape (m,); u, y: shape (N, m)."""
    return np.asarray(_fit(system, u, y, 0), dtype=np.float64)


def _fit(system: System | StateSpace, u: Array, y: Array, axis: int | None) -> Array:
    simulated = system.simulate(u)
    if simulated.shape != y.shape:
        raise ValueError(f"y must have shape {simulated.shape}, got {y.shape}")
    error = np.linalg.norm(y - simulated, axis=axis)
    return 1.0 - error / np.linalg.norm(y - y.mean(axis=0), axis=axis)


def _covariance(u: Array, gain: float, pole: float, delay: int, variance: float) -> Array:
    """Of (b, pole): variance (J^T J)^-1, J the derivatives of the simulation."""
    _, by_gain = _best_gain(u, u, delay, pole)
    _, by_pole = _best_gain(by_gain, u, 1, pole)
    J = np.stack((by_gain.ravel(), gain * by_pole.ravel()), axis=1)
    return np.asarray(variance * np.linalg.pinv(J.T @ J), dtype=np.float64)


def _best_gain(u: Array, y: Array, delay: int, pole: float) -> tuple[float, Array]:
    """Least-squares b, and the output for b = 1."""
    x = recursion(np.ones(1), np.array([1.0, -pole]), delayed(u, delay))
    size = float(np.square(x).sum())
    return (float((x * y).sum()) / size if size > 0.0 else 0.0), x


class LearningRecord(NamedTuple):
    """One learning experiment: its last correction u_K, first error e_0 and last e_K, (N, n)."""

    correction: ArrayLike
    first_error: ArrayLike
    last_error: ArrayLike
    motion_end: int
    """Sample at which the reference comes to rest."""


def learning_data(
    records: Iterable[LearningRecord], motors: Sequence[int] | None = None
) -> tuple[Array, Array]:
    """(u, y) = (sum of u_K, sum of e_0 - e_K) of some motors, shape (N, motors). Thesis (9.11).

    N: the smallest `motion_end`. motors: columns, counted from 0; None: all. Differences of errors
    are formed and summed in the precision in which they are stored.
    """
    records = list(records)
    if not records:
        raise ValueError("learning data must hold at least one record")
    n = min(record.motion_end for record in records)
    if n < 1:
        raise ValueError(f"motion_end must be >= 1 sample, got {n}")
    columns = slice(None) if motors is None else list(motors)

    def part(signal: ArrayLike) -> Array:
        as_record(signal, "a learning record")
        return np.asarray(signal)[:n, columns]

    u = np.asarray(sum(part(r.correction).astype(np.float64) for r in records))
    y = np.asarray(sum(part(r.first_error) - part(r.last_error) for r in records))
    return u, y.astype(np.float64)


def identify(
    records: Iterable[LearningRecord], sample_time: float, motors: Sequence[int] | None = None
) -> FirstOrderModel:
    """One first-order T_u for some motors together, by output error on `learning_data`."""
    u, y = learning_data(records, motors)
    return fit_first_order(u, y, sample_time)
