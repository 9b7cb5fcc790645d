"""A first-order lag with delay fitted to simulated outputs: what ARX cannot do under friction.

y(t) = b / (1 - a q^-1) u(t - n_k) + error. ARX minimises the one-step prediction error, and smooth
records predict themselves: it then prefers slow poles. Here the error of the simulation is
minimised. Thesis (9.11), (9.12).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import recursion
from ..models.system import System
from ..plant import as_record

_SLOWEST = 0.98  # pole; slower ones cannot be told from an integrator in records of a second


@dataclass(frozen=True, kw_only=True, eq=False)
class FirstOrder:
    """T_u(q) = b q^-delay / (1 - pole q^-1)."""

    system: System
    delay: int
    """[samples]."""
    pole: float
    fit: float
    """1 - ||y - simulated|| / ||y - mean||, of all experiments together."""

    @property
    def static_gain(self) -> float:
        return self.system.static_gain

    @property
    def total_delay(self) -> float:
        """[samples]: the delay and the lag, pole / (1 - pole)."""
        return self.delay + self.pole / (1.0 - self.pole)


def fit_first_order(
    u: ArrayLike, y: ArrayLike, sample_time: float, *, delays: Iterable[int] = range(11)
) -> FirstOrder:
    """Least squares of the simulation error; u, y: shape (N, m), m experiments from rest.

    For each delay the pole is searched in [0, 0.98]; the gain follows in closed form.

    Raises:
        ValueError: shapes that differ, or an input or output that is zero throughout.
    """
    from scipy.optimize import minimize_scalar

    u, y = as_record(u, "u"), as_record(y, "y")
    if u.shape != y.shape:
        raise ValueError(f"u and y must have one shape, got {u.shape} and {y.shape}")
    if not u.any() or not y.any():
        raise ValueError("u and y must not be zero throughout")

    def left_over(pole: float, delay: int) -> float:
        gain, x = _best_gain(u, y, delay, pole)
        return float(np.square(y - gain * x).sum())

    best = None
    for delay in delays:
        pole = float(
            minimize_scalar(left_over, args=(delay,), bounds=(0.0, _SLOWEST), method="bounded").x  # type: ignore[attr-defined]
        )
        left = left_over(pole, delay)
        if best is None or left < best[0]:
            best = (left, delay, pole)
    if best is None:
        raise ValueError("delays must not be empty")
    left, delay, pole = best
    gain, _ = _best_gain(u, y, delay, pole)
    b = np.concatenate((np.zeros(delay), [gain]))
    return FirstOrder(
        system=System(b, np.array([1.0, -pole]), sample_time),
        delay=delay,
        pole=pole,
        fit=1.0 - np.sqrt(left / np.square(y - y.mean(axis=0)).sum()),
    )


def _best_gain(u: Array, y: Array, delay: int, pole: float) -> tuple[float, Array]:
    """b that fits best, and the output for b = 1."""
    delayed = np.concatenate((np.zeros((delay, u.shape[1])), u))[: len(u)]
    x = recursion(np.ones(1), np.array([1.0, -pole]), delayed)
    size = float(np.square(x).sum())
    return (float((x * y).sum()) / size if size > 0.0 else 0.0), x


def fit_of(system: System, u: ArrayLike, y: ArrayLike) -> float:
    """How well a model simulates data it was not fitted to: 1 - ||y - y_sim|| / ||y - mean||."""
    u, y = as_record(u, "u"), as_record(y, "y")
    error = np.linalg.norm(y - system.simulate(u))
    return float(1.0 - error / np.linalg.norm(y - y.mean(axis=0)))
