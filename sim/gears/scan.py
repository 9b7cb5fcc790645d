"""Scan of the orders of a joint's error, periods per joint turn, without knowledge of its gear."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array

from .residual_spectra import Observation, as_real

SMALLEST = 20.0
"""Smallest order of a scan; errors of a lower one are too slow for the sensor's band."""
COARSE, FINE = 2.0, 1.0
"""Distance of the orders of a scan: fine for joints whose travel tells close ones apart."""
REFINED = 0.05
"""Accuracy of an order after the scan."""
Candidate = tuple[int, float]
"""Joint, from 0, and order."""


@dataclass(frozen=True, eq=False)
class Scan:
    """Energy of the weighted residual that each order of each joint explains alone."""

    orders: tuple[Array, ...]
    explained: tuple[Array, ...]
    unit: tuple[Array, ...]
    """Energy of an error of one radian, of a phase between the best and the worst. For each joint,
    (K,)."""
    energy: float
    """Of the residual."""

    def __add__(self, other: "Scan") -> "Scan":
        explained, unit = (
            tuple(a + b for a, b in zip(these, those, strict=True))
            for these, those in ((self.explained, other.explained), (self.unit, other.unit))
        )
        return Scan(self.orders, explained, unit, self.energy + other.energy)

    @property
    def typical(self) -> Array:
        """(n,), median over the orders of each joint: 1.39 times the level of chance."""
        return np.array([np.median(values) for values in self.explained])


def resolution(phi: Array) -> Array:
    """(n,), distance of two orders that the travel of each joint tells apart; phi (M, n)."""
    return 2.0 * np.pi / np.maximum(np.ptp(phi, axis=0), 1e-2)


def grids(apart: Array, largest: float) -> tuple[Array, ...]:
    """Orders to scan, for each joint, by its resolution (n,)."""
    steps = np.where(apart > 2.0 * COARSE, COARSE, FINE)
    return tuple(np.arange(SMALLEST, largest + step / 2, step) for step in steps)


def scan(one: Observation, orders: tuple[Array, ...], step: Callable[[], None]) -> Scan:
    """Scan of an observation; `step` is called after each joint."""
    y, both = as_real(one.target), list[Array]()
    for joint, own in enumerate(orders):
        both.append(np.array([_alone(one, joint, order, y) for order in own]).T)
        step()
    explained, unit = ([rows[k] for rows in both] for k in (0, 1))
    return Scan(orders, tuple(explained), tuple(unit), float(y @ y))


def _alone(one: Observation, joint: int, order: float, y: Array) -> tuple[float, float]:
    """Energy that an order explains alone, and that of an error of one radian."""
    X = as_real(one.columns(joint, order))
    gram, score = X.T @ X, X.T @ y
    power = float(np.trace(gram))
    ridge = 1e-6 * power + np.finfo(np.float32).tiny
    explained = score @ np.linalg.solve(gram + ridge * np.eye(2), score)
    return float(explained), 0.5 * power


def peaks(one: Scan, apart: Array, strongest: int) -> list[Candidate]:
    """Strongest orders of each joint, each farther from the others than its resolution (n,)."""
    found: list[Candidate] = []
    for joint, (orders, values) in enumerate(zip(one.orders, one.explained, strict=True)):
        own: list[float] = []
        for order in orders[np.argsort(-values)].tolist():
            if all(abs(order - other) >= max(apart[joint], FINE) for other in own):
                own.append(order)
            if len(own) == strongest:
                break
        found += [(joint, order) for order in own]
    return found


def refined(
    observations: Sequence[Observation], targets: Sequence[Array], candidate: Candidate, half: float
) -> Candidate:
    """The order within `half` of a candidate that explains most of the targets, one each."""
    joint, order = candidate
    pairs = [(one, as_real(y)) for one, y in zip(observations, targets, strict=True)]

    def missed(value: float) -> float:
        return -sum(_alone(one, joint, value, y)[0] for one, y in pairs)

    return joint, smallest(missed, order - half, order + half, REFINED)


def smallest(missed: Callable[[float], float], low: float, high: float, accuracy: float) -> float:
    """Where a function is smallest between two bounds."""
    from scipy.optimize import minimize_scalar

    how: dict[str, Any] = {"method": "bounded", "options": {"xatol": accuracy}}
    found: Any = minimize_scalar(missed, bounds=(low, high), **how)
    return float(found.x)
