"""Eigenvalues of the iteration Q (I - L T_u) over frequency: the Nyquist view of coupled motors.

The correction of an infinite record converges if all loci stay inside the unit circle at 0. The
largest singular value, (7.5), then says whether it does so without growing at first: for a normal
matrix both are the same, otherwise the singular value is the larger one. For one motor the locus
is that of 1 - L T_u, whose circle is the one at +1 for L T_u. MacFarlane and Postlethwaite, "The
generalized Nyquist stability criterion and multivariable root loci" (1977), for the loci.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from armside.arrays import Array

from ..filters import PerColumn, RecordFilter
from ..models.peak import peak
from ..models.system import Complex, require_stable
from ..models.system_matrix import Model
from .criterion import (
    frequency_grid,
    heuristic_gain,
    iteration_poles,
    require_one_cutoff,
    require_one_sample_time,
)

_POWER = 4  # of the iteration, whose largest singular value bounds the loci
_MOST_POLES = 600  # of that power: fewer factors for plants with many poles
_ZOOMS, _POINTS = 5, 33  # around the largest modulus: its neighbours come 1e-6 closer


@dataclass(frozen=True, eq=False)
class Eigenloci:
    """Eigenvalues (M, n) at the frequencies omega (M,) [rad/sample], a locus in each column."""

    omega: Array
    values: Complex
    bound: float | None
    """Guaranteed upper bound of all moduli, sup ||(Q (I - L T_u))^k||_2^(1/k); None for a Q
    whose poles are not known."""

    @property
    def spectral_radius(self) -> float:
        """Largest modulus of the loci: the factor by which the correction converges in the end."""
        return float(np.abs(self.values).max())

    @property
    def limiting_omega(self) -> float:
        """Frequency of that modulus [rad/sample]."""
        return float(self.omega[np.abs(self.values).max(axis=1).argmax()])

    @property
    def is_met(self) -> bool:
        """All loci are inside the unit circle, at all frequencies where a bound is known."""
        return (self.spectral_radius if self.bound is None else self.bound) < 1.0


def eigenloci(
    T_u: Model, gamma: PerColumn | Array, delta: int | tuple[int, ...], Q: RecordFilter
) -> Eigenloci:
    """Loci of L = gamma q^delta, arguments as of `heuristic_criterion`.

    Frequencies are refined at the poles, and where the largest modulus is. The power k of the bound
    is 4, or less for plants with many poles. Raises ValueError for an unstable T_u.
    """
    require_stable(T_u, "T_u")
    L = heuristic_gain(T_u, gamma, delta)
    require_one_sample_time(T_u, Q)

    def iteration(omega: Array) -> Complex:
        T, gain, q = T_u.response(omega), L.response(omega), np.asarray(Q.response(omega))
        if T.ndim == 1:
            require_one_cutoff(q)
            return (q * (1.0 - gain * T)).astype(np.complex128)[:, None, None]
        rows = q[:, None] if q.ndim == 1 else q
        return rows[:, :, None] * (np.eye(T.shape[1]) - gain @ T)

    omega, bound = _frequencies(iteration, iteration_poles(T_u, delta, Q))
    values = np.linalg.eigvals(iteration(omega))
    for _ in range(_ZOOMS):
        at = int(np.abs(values).max(axis=1).argmax())
        low, high = omega[max(at - 1, 0)], omega[min(at + 1, len(omega) - 1)]
        more = np.linspace(low, high, _POINTS)
        omega, first = np.unique(np.concatenate((omega, more)), return_index=True)
        values = np.concatenate((values, np.linalg.eigvals(iteration(more))))[first]
    return Eigenloci(omega, _joined(values.astype(np.complex128)), bound)


def _frequencies(
    iteration: Callable[[Array], Complex], poles: Complex | None
) -> tuple[Array, float | None]:
    if poles is None:
        return frequency_grid(), None
    k = int(np.clip(_MOST_POLES // max(len(poles), 1), 1, _POWER))

    def growth(omega: Array) -> Array:
        power = np.linalg.matrix_power(iteration(omega), k)
        return np.square(np.linalg.norm(power, ord=2, axis=(1, 2)))

    largest = peak(growth, np.tile(poles, k), frequency_grid())
    return largest.omega, float(largest.bound ** (0.5 / k))


def _joined(values: Complex) -> Complex:
    """Each eigenvalue in the column of the one next to it at the frequency before."""
    from scipy.optimize import linear_sum_assignment

    joined = values.copy()
    for before, here in pairwise(joined):
        distance = np.abs(before[:, None] - here[None, :])
        here[:] = here[linear_sum_assignment(distance)[1]]
    return joined
