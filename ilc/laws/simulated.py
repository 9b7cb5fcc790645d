"""Learning through a simulation of the plant, for plants that are far from linear.

A linear T_u misleads where friction holds a motor: its gain changes tenfold within one record. Here
the law learns on a simulated plant, whose error is brought to that of the real one by what the
last run left unexplained:

    d_k     = Q_d(e_k - e_m(u_k))
    u_{k+1} = the best of v_0 = u_k, v_{j+1} = law(v_j, e_m(v_j) + d_k)

with e_m(v) the simulated error. The fixed point is that of e_k = 0 within the band of Q_d, however
wrong the simulation is; how wrong it is decides how fast, and whether, learning gets there.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from ..records import records
from .law import FirstOrderLaw

_FRUITLESS = 3
"""Passes without a smaller residual after which a step ends."""
_SMALLER = 0.98
"""Factor by which a residual counts as smaller."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Simulated(FirstOrderLaw):
    """Learning on a simulated plant between two runs of the real one."""

    simulation: Callable[[Array], Array] = field(repr=False)
    """Error (N, n) of the simulated plant after a correction (N, n)."""
    law: FirstOrderLaw
    """Law of the passes on the simulated plant."""
    Q_d: RecordFilter = ALL_PASS
    """Filter of what the simulation leaves unexplained."""
    weight: tuple[float, ...]
    """(n,), weights of the columns in the size of a residual: the largest magnitude."""
    passes: int = 12
    """Most passes on the simulated plant before each run."""

    def __post_init__(self) -> None:
        if self.passes < 1:
            raise ValueError(f"passes must be >= 1, got {self.passes}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.weight) != n_columns:
            raise ValueError(f"weight must have {n_columns} values, got {len(self.weight)}")
        self.law.check(n_samples, n_columns)
        self.Q_d.check(n_samples, n_columns)

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        simulated = self.simulation(correction)
        unexplained = self.Q_d(error - simulated)
        best, smallest, fruitless = correction, np.inf, 0
        for left in reversed(range(self.passes + 1)):
            residual = simulated + unexplained
            size = float(np.abs(residual * np.array(self.weight)).max())
            fruitless = 0 if size < _SMALLER * smallest else fruitless + 1
            if size < smallest:
                best, smallest = correction, size
            if not left or fruitless >= _FRUITLESS:
                break
            correction = self.law(correction, residual)
            simulated = self.simulation(correction)
        return best
