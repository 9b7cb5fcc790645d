"""Heuristic design proposed from a model of T_u: gain and shift for a bandwidth, or for the
highest of several, with one sentence on the expected convergence."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..filters import ZeroPhaseButterworth
from ..laws.heuristic import Heuristic
from ..models.system import System, require_stable
from ..records import as_number
from .criterion import (
    Criterion,
    frequency_grid,
    hertz,
    heuristic_criterion,
    shift_response,
)
from .limits import largest_cutoff, largest_gamma

SLOWEST = 0.99
"""Contraction an iteration beyond which a design counts as infeasible: 300 iterations to 5 %."""
FAST_ENOUGH = 0.5
"""Contraction an iteration at or below which `design_for` offers the next higher cutoff."""
TRUSTED_FIT = 0.8
"""Fit of a model below which `design_for` keeps to the lowest cutoff."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """Design variables of the heuristic law with their convergence criterion."""

    T_u: System
    """Model that the design was made for."""
    Q: ZeroPhaseButterworth
    gamma: float
    delta: int
    criterion: Criterion
    largest_gamma: float
    """Supremum of the admissible gains at this shift and cutoff."""

    @property
    def law(self) -> Heuristic:
        return Heuristic(Q=self.Q, gamma=self.gamma, delta=self.delta)

    @property
    def cutoff(self) -> float:
        """Cutoff of Q [Hz]."""
        return float(np.max(self.Q.cutoff))

    @cached_property
    def largest_cutoff(self) -> float:
        """Supremum of the cutoffs at this gain and shift [Hz]; infinity: Q = 1 is admissible."""
        return largest_cutoff(self.T_u, self.gamma, self.delta, order=self.Q.order)

    @property
    def contraction(self) -> float:
        """Largest factor on ||e_k - e_inf|| in an iteration."""
        return self.criterion.contraction

    @property
    def iterations_to_5_percent(self) -> int:
        """Iterations after which ||e_k - e_inf|| is at most 5 % of its first value."""
        return max(1, int(np.ceil(np.log(0.05) / np.log(max(self.contraction, 1e-300)))))

    def residual(self, frequency: float) -> float:
        """|e_inf| / |e_0| at a frequency [Hz]: the fraction of the error that is never learned."""
        omega = 2.0 * np.pi * frequency * self.T_u.sample_time
        q = self.Q.response(omega)
        LT = shift_response(self.gamma, self.delta, omega) * self.T_u.response(omega)
        return float(np.abs((1.0 - q) / (1.0 - q * (1.0 - LT))))

    def sentence(self) -> str:
        """Predicted convergence and the limit of the design, for a person."""
        at = float(hertz(self.criterion.limiting_omega, self.T_u.sample_time))
        half = 0.5 * self.cutoff
        limit = (
            "this model would allow learning without Q"
            if np.isinf(self.largest_cutoff)
            else f"a cutoff of {self.largest_cutoff:.3g} Hz would no longer contract"
        )
        return (
            f"With gamma = {self.gamma:.3g}, delta = {self.delta} and a cutoff of "
            f"{self.cutoff:.3g} Hz the distance to the final error falls at least to "
            f"{self.contraction:.3g} of itself in every iteration, to 5 % within "
            f"{self.iterations_to_5_percent}, and {100 * self.residual(half):.2g} % of the error "
            f"at {half:.3g} Hz stays; the slowest frequency is {at:.3g} Hz, and {limit}."
        )


def propose(
    T_u: System,
    bandwidth: float,
    *,
    deltas: range = range(-5, 51),
    fraction: float = 0.6,
    order: int = 2,
) -> Proposal:
    """Gain and shift for a zero-phase Butterworth Q with its cutoff at `bandwidth` [Hz].

    The shift is the one whose iteration contracts fastest; the gain is 1/|T_u(0)|, at most
    `fraction` of the largest admissible one, which leaves a gain margin of 1/fraction.

    Raises:
        ValueError: an unstable T_u, a bandwidth beyond Nyquist, or an infeasible design: no
            shift in `deltas` contracts by `SLOWEST`. The message states the feasible bandwidth.
    """
    require_stable(T_u, "T_u")
    as_number(bandwidth, "bandwidth", 0.0)
    if not len(deltas):
        raise ValueError(f"deltas must hold at least one shift, got {deltas}")
    if (gain := T_u.static_gain) <= 0.0:
        raise ValueError(f"the static gain of T_u must be > 0, as gamma must, got {gain:.3g}")
    if not 0.0 < as_number(fraction, "fraction") < 1.0:
        raise ValueError(f"fraction must be in (0, 1), got {fraction}")
    found = list(_contracting(T_u, bandwidth, deltas, fraction, order))
    if not found:
        feasible = _largest_bandwidth(T_u, bandwidth, deltas, fraction, order)
        raise ValueError(
            f"infeasible design: with a cutoff of {bandwidth:g} Hz no shift from {deltas[0]} to "
            f"{deltas[-1]} contracts by {SLOWEST:g} an iteration; up to {feasible:.3g} Hz one does"
        )
    # Fastest first; among nearly equal ones the shift with the widest admissible gain.
    fastest = min(candidate.contraction for candidate in found)
    near = [candidate for candidate in found if candidate.contraction <= fastest + 0.005]
    return max(near, key=lambda candidate: candidate.largest_gamma)


def design_for(
    T_u: System, cutoffs: Sequence[float], *, fit: float = 1.0, deltas: range = range(13)
) -> Proposal:
    """Proposal with the highest of the cutoffs [Hz, rising] up to which designs are fast enough.

    fit: of T_u to its data; below `TRUSTED_FIT` only the lowest cutoff is offered. Raises
    ValueError if no shift contracts at the lowest cutoff.
    """
    if not len(cutoffs):
        raise ValueError("cutoffs must hold at least one cutoff, got none")
    offered = cutoffs if fit >= TRUSTED_FIT else cutoffs[:1]
    best = propose(T_u, offered[0], deltas=deltas)
    for cutoff in offered[1:]:
        try:
            higher = propose(T_u, cutoff, deltas=deltas)
        except ValueError:  # no shift contracts at this cutoff, nor at a higher one
            break
        if higher.contraction > FAST_ENOUGH:
            break
        best = higher
    return best


def _contracting(
    T_u: System, bandwidth: float, deltas: range, fraction: float, order: int
) -> Iterator[Proposal]:
    """One proposal for each shift that contracts fast enough.

    A plain grid, which can only miss a peak, rules out most shifts.
    """
    Q = ZeroPhaseButterworth(bandwidth, T_u.sample_time, order)
    limits = largest_gamma(T_u, deltas, [bandwidth], order=order)[:, 0]
    grid = frequency_grid()
    for delta, limit in zip(deltas, limits.tolist(), strict=True):
        gamma = float(min(1.0 / T_u.static_gain, fraction * limit))
        if heuristic_criterion(T_u, gamma, delta, Q, grid).contraction > SLOWEST:
            continue
        result = heuristic_criterion(T_u, gamma, delta, Q)
        if result.contraction <= SLOWEST:
            yield Proposal(T_u, Q, gamma, delta, result, limit)


def _largest_bandwidth(
    T_u: System, infeasible: float, deltas: range, fraction: float, order: int
) -> float:
    """Largest feasible bandwidth [Hz] below an infeasible one, to 1 %."""
    low, high = 0.0, infeasible
    while high - low > 0.01 * high and high > 1e-3 * infeasible:
        middle = 0.5 * (low + high)
        if next(_contracting(T_u, middle, deltas, fraction, order), None) is not None:
            low = middle
        else:
            high = middle
    return low
