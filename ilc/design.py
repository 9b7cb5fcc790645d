"""A first design from a model and a wanted bandwidth, with one sentence on what to expect."""

from dataclasses import dataclass

import numpy as np

from .analysis.criterion import (
    Criterion,
    frequency_grid,
    hertz,
    heuristic_criterion,
    largest_cutoff,
    largest_gamma,
    shift_response,
)
from .filters import ZeroPhaseButterworth
from .laws.heuristic import Heuristic
from .system import System, require_stable


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
        return int(np.ceil(np.log(0.05) / np.log(self.contraction)))

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
            shift in `deltas` contracts. The message says which bandwidth would do.
    """
    require_stable(T_u, "T_u")
    if T_u.static_gain <= 0.0:
        raise ValueError(
            f"the static gain of T_u must be > 0, as gamma must, got {T_u.static_gain:.3g}"
        )
    if not 0.0 < share < 1.0:
        raise ValueError(f"share must be in (0, 1), got {share}")
    Q = ZeroPhaseButterworth(bandwidth, T_u.sample_time, order)
    omega = frequency_grid()
    shifts = np.array(deltas)
    limits = largest_gamma(T_u, shifts, [bandwidth], order=order)[:, 0]
    gammas = np.minimum(1.0 / T_u.static_gain, share * limits)
    candidates = [
        (heuristic_criterion(T_u, gamma, int(delta), Q, omega), gamma, int(delta), limit)
        for gamma, delta, limit in zip(gammas, shifts, limits, strict=True)
        if gamma > 1e-6
    ]
    candidates = [candidate for candidate in candidates if candidate[0].is_met]
    if not candidates:
        gamma = 0.5 / T_u.static_gain
        best = max(largest_cutoff(T_u, gamma, int(delta), order=order) for delta in shifts)
        raise ValueError(
            f"infeasible design: with a cutoff of {bandwidth:g} Hz no shift from {shifts[0]} to "
            f"{shifts[-1]} contracts for any gain; up to {best:.3g} Hz one does"
        )
    # Fastest first; among nearly equal ones the shift with the widest admissible gain.
    fastest = min(candidate[0].contraction for candidate in candidates)
    near = [c for c in candidates if c[0].contraction <= fastest + 0.005]
    result, gamma, delta, limit = max(near, key=lambda candidate: candidate[3])
    return Proposal(
        law=Heuristic(Q=Q, gamma=float(gamma), delta=delta),
        gamma=float(gamma),
        delta=delta,
        cutoff=bandwidth,
        T_u=T_u,
        criterion=result,
        largest_gamma=float(limit),
        largest_cutoff=largest_cutoff(T_u, float(gamma), delta, order=order),
    )
