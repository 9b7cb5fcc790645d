"""A first design from a model and a wanted bandwidth, with one sentence on what to expect."""

from dataclasses import dataclass

import numpy as np

from ..filters import ZeroPhaseButterworth
from ..laws.heuristic import Heuristic
from ..models.system import System, require_stable
from .criterion import (
    Criterion,
    frequency_grid,
    hertz,
    heuristic_criterion,
    largest_cutoff,
    largest_gamma,
    shift_response,
)

SLOWEST = 0.99
"""Contraction an iteration beyond which a design counts as infeasible: 300 iterations to 5 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Proposal:
    """Design variables of the heuristic law, and what the criterion says about them."""

    law: Heuristic
    gamma: float
    delta: int
    cutoff: float
    """[Hz]."""
    T_u: System
    """The model it was made for."""
    criterion: Criterion
    largest_gamma: float
    """At this shift and cutoff."""
    largest_cutoff: float
    """At this gain and shift [Hz]; infinity: Q = 1 would do."""

    @property
    def contraction(self) -> float:
        """||e_k - e_inf|| shrinks at least by this factor in every iteration."""
        return self.criterion.contraction

    @property
    def iterations_to_5_percent(self) -> int:
        """After which the distance to the limit is at most 5 % of what it was."""
        return max(1, int(np.ceil(np.log(0.05) / np.log(max(self.contraction, 1e-300)))))

    def left_over(self, frequency: float) -> float:
        """|e_inf| / |e_0| at a frequency [Hz], the part that is never learned."""
        omega = 2.0 * np.pi * frequency * self.T_u.sample_time
        q = self.law.Q.response(omega)
        LT = shift_response(self.gamma, self.delta, omega) * self.T_u.response(omega)
        return float(np.abs((1.0 - q) / (1.0 - q * (1.0 - LT))))

    def sentence(self) -> str:
        """What is predicted, and what limits it."""
        at = float(hertz(self.criterion.limiting_omega, self.T_u.sample_time))
        half = 0.5 * self.cutoff
        limit = (
            "this model would allow learning without Q"
            if np.isinf(self.largest_cutoff)
            else f"a cutoff of {self.largest_cutoff:.3g} Hz would no longer contract"
        )
        return (
            f"With gamma = {self.gamma:.3g}, delta = {self.delta} and a cutoff of "
            f"{self.cutoff:.3g} Hz the distance to the final error shrinks at least by "
            f"{self.contraction:.3g} in every iteration, to 5 % within "
            f"{self.iterations_to_5_percent}, and {100 * self.left_over(half):.2g} % of the error "
            f"at {half:.3g} Hz stays; the slowest frequency is {at:.3g} Hz, and {limit}."
        )


def propose(
    T_u: System,
    bandwidth: float,
    *,
    deltas: range = range(-5, 51),
    share: float = 0.6,
    order: int = 2,
) -> Proposal:
    """Gain and shift for a zero-phase Butterworth Q with its cutoff at `bandwidth` [Hz].

    The shift is the one whose iteration contracts fastest; the gain is 1/|T_u(0)|, at most
    `share` of the largest admissible one, so that a model error of 1/share in gain is survived.

    Raises:
        ValueError: an unstable T_u, a bandwidth beyond Nyquist, or an infeasible design: no
            shift in `deltas` contracts by `SLOWEST`. The message says which bandwidth would do.
    """
    require_stable(T_u, "T_u")
    if T_u.static_gain <= 0.0:
        raise ValueError(
            f"the static gain of T_u must be > 0, as gamma must, got {T_u.static_gain:.3g}"
        )
    if not 0.0 < share < 1.0:
        raise ValueError(f"share must be in (0, 1), got {share}")
    found = _candidates(T_u, bandwidth, deltas, share, order)
    if not found:
        feasible = _largest_bandwidth(T_u, bandwidth, deltas, share, order)
        raise ValueError(
            f"infeasible design: with a cutoff of {bandwidth:g} Hz no shift from {deltas[0]} to "
            f"{deltas[-1]} contracts by {SLOWEST:g} an iteration; up to {feasible:.3g} Hz one does"
        )
    # Fastest first; among nearly equal ones the shift with the widest admissible gain.
    fastest = min(candidate.criterion.contraction for candidate in found)
    near = [c for c in found if c.criterion.contraction <= fastest + 0.005]
    best = max(near, key=lambda candidate: candidate.largest_gamma)
    return Proposal(
        law=Heuristic(
            Q=ZeroPhaseButterworth(bandwidth, T_u.sample_time, order),
            gamma=best.gamma,
            delta=best.delta,
        ),
        gamma=best.gamma,
        delta=best.delta,
        cutoff=bandwidth,
        T_u=T_u,
        criterion=best.criterion,
        largest_gamma=best.largest_gamma,
        largest_cutoff=largest_cutoff(T_u, best.gamma, best.delta, order=order),
    )


@dataclass(frozen=True, eq=False)
class _Candidate:
    gamma: float
    delta: int
    largest_gamma: float
    criterion: Criterion


def _candidates(
    T_u: System, bandwidth: float, deltas: range, share: float, order: int
) -> list[_Candidate]:
    """One for each shift that contracts fast enough."""
    Q, omega = ZeroPhaseButterworth(bandwidth, T_u.sample_time, order), frequency_grid()
    limits = largest_gamma(T_u, deltas, [bandwidth], order=order)[:, 0]
    found = []
    for delta, limit in zip(deltas, limits, strict=True):
        gamma = float(min(1.0 / T_u.static_gain, share * limit))
        result = heuristic_criterion(T_u, gamma, delta, Q, omega)
        if result.contraction <= SLOWEST:
            found.append(_Candidate(gamma, delta, float(limit), result))
    return found


def _largest_bandwidth(
    T_u: System, infeasible: float, deltas: range, share: float, order: int
) -> float:
    """[Hz] below an infeasible bandwidth, to 1 %."""
    low, high = 0.0, infeasible
    while high - low > 0.01 * high and high > 1e-3 * infeasible:
        middle = 0.5 * (low + high)
        if _candidates(T_u, middle, deltas, share, order):
            low = middle
        else:
            high = middle
    return low
