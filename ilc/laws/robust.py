"""L by minimax model matching: the smallest contraction sup |Q (1 - L T_u)| of the criterion (7.5).

    L = arg min  max over omega of |Q| sqrt(|1 - L T_u|^2 + (Delta |L T_u|)^2)

The two steps of de Roover, "Synthesis of a robust iterative learning controller using an H-infinity
approach" (1996): Q is chosen for where the model holds, then L for that Q. His synthesis returns a
causal state-space L from Riccati equations. Here L is a filter of finite length that looks ahead,
found on a grid of frequencies by weighted least squares whose weights follow the residual (Lawson,
1961). Peaks between the frequencies, such as that of a resonance, are located with a bound
(`models.peak`) and added to the grid. Each weighting also bounds from below what any filter of
this length with taps no larger reaches, so `reached` and `least` state how far from the optimum L
is at most. Larger taps, which the trace of ridge keeps away, may do better where Q T_u is almost 0.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.peak import Peak, peak
from ..models.system import Complex, require_stable, unit_circle
from ..models.system_matrix import Model, require_effect, single_response
from ..records import records

_ROUNDS = 200
_CLOSE = 1.02
"""Ratio of `reached` to `least` at which the rounds end, and of a peak between the frequencies of
the grid to the largest value on them up to which it is left there."""
_EXCHANGES = 8
"""Grids at most."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Matched:
    """Filter sum_i l_i q^(lead - i), samples beyond the ends of a record held."""

    taps: Array
    """(n,)."""
    lead: int
    """[samples]."""
    reached: float
    """Largest value of the criterion over all frequencies; a contraction if below 1 and Delta 0."""
    least: float
    """No filter of this length whose taps have at most the norm `bounded` does better."""
    bounded: float = 0.0
    """Norm of the taps up to which `least` holds."""
    bound: float | None = None
    """Guaranteed upper bound of the criterion at all frequencies; None where Q states no poles:
    `reached` is then of the grid alone."""

    def check(self, n_samples: int, n_columns: int) -> None:
        """Accept every shape."""

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        behind = len(self.taps) - 1 - self.lead
        held = np.pad(signal, ((max(behind, 0), max(self.lead, 0)), (0, 0)), mode="edge")
        moved = [np.convolve(column, self.taps, mode="valid") for column in held.T]
        return np.stack(moved, axis=1)

    def response(self, omega: ArrayLike) -> Complex:
        """(M,) at omega [rad/sample]."""
        q = unit_circle(omega)
        return np.asarray(q**self.lead * np.polyval(self.taps[::-1], 1.0 / q), dtype=np.complex128)


def h_infinity(
    T_u: Model,
    Q: RecordFilter,
    *,
    n_taps: int = 60,
    lead: int | None = None,
    uncertainty: float = 0.0,
    n_grid: int = 600,
) -> Matched:
    """L for a model with one input and one output and a Q of one cutoff.

    Args:
        lead: samples that L looks ahead; half of the taps if None.
        uncertainty: Delta, relative error of T_u at every frequency. Where the criterion is below
            1 / sqrt(2) the iteration contracts for every T_u (1 + d), |d| <= Delta.

    Raises ValueError for an unstable T_u, one with several inputs, or values out of range.
    """
    require_stable(T_u, "T_u")
    single_response(T_u, np.zeros(1))
    require_effect(T_u)
    lead = n_taps // 2 if lead is None else lead
    if n_taps < 1 or not 0 <= lead < n_taps:
        raise ValueError(f"lead must be in 0 to n_taps - 1, got {lead} of {n_taps} taps")
    if not (np.isfinite(uncertainty) and uncertainty >= 0.0):
        raise ValueError(f"uncertainty must be >= 0, got {uncertainty}")
    matching = _Matching(T_u, Q, uncertainty, lead, n_taps)
    omega, found = np.pi * (np.arange(n_grid) + 0.5) / n_grid, list[Matched]()
    for _ in range(_EXCHANGES):
        best = matching.on(omega)
        if (seen := matching.peak(best, omega)) is None:
            return best
        reached, bound = np.sqrt((seen.values.max(), seen.bound))
        found.append(replace(best, reached=float(reached), bound=float(bound)))
        if reached <= _CLOSE * best.reached:
            break
        ends = np.concatenate(([-np.inf], seen.values, [-np.inf]))
        local = (seen.values >= ends[:-2]) & (seen.values > ends[2:])
        omega = np.union1d(omega, seen.omega[local & (seen.values > best.reached**2)])
    proven = max(found, key=lambda each: each.least)
    best = min(found, key=lambda each: each.reached)
    return replace(best, least=min(proven.least, best.reached), bounded=proven.bounded)


@dataclass(frozen=True)
class _Matching:
    """Criterion that the taps minimise."""

    T_u: Model
    Q: RecordFilter
    uncertainty: float
    lead: int
    n_taps: int

    def on(self, omega: Array) -> Matched:
        """Taps by weighted least squares at some frequencies; `reached` and `least` are there."""
        gain = np.abs(self.Q.response(omega))
        if gain.ndim != 1:
            raise ValueError("Q must have one cutoff for all columns")
        delays = unit_circle(omega)[:, None] ** (self.lead - np.arange(self.n_taps))
        LT = (gain * single_response(self.T_u, omega))[:, None] * delays
        A = np.stack((LT, self.uncertainty * LT))  # (2, M, n)
        b = np.stack((gain, np.zeros(len(omega))))
        weight, best = np.full(len(omega), 1.0 / len(omega)), None
        least = bounded = 0.0
        for _ in range(_ROUNDS):
            taps = _weighted(A, b, weight)
            size = np.linalg.norm(A @ taps - b, axis=0)
            if (bound := float(np.sqrt(weight @ np.square(size)))) > least:
                least, bounded = bound, float(np.linalg.norm(taps))
            if best is None or size.max() < best.reached:
                best = Matched(taps=taps, lead=self.lead, reached=float(size.max()), least=0.0)
            if best.reached <= _CLOSE * least:
                break
            weight = weight * size / (weight @ size)
        assert best is not None
        return replace(best, least=min(least, best.reached), bounded=bounded)

    def peak(self, L: Matched, omega: Array) -> Peak | None:
        """Squared criterion of L over all frequencies; None where Q states no poles."""
        if (poles := getattr(self.Q, "poles", None)) is None:
            return None

        def power(omega: Array) -> Array:
            LT = L.response(omega) * single_response(self.T_u, omega)
            size = np.square(np.abs(1.0 - LT)) + np.square(self.uncertainty * np.abs(LT))
            return np.square(np.abs(self.Q.response(omega))) * size

        taps = np.zeros(self.n_taps - 1)
        every = np.concatenate((self.T_u.all_poles, poles, taps)).astype(np.complex128)
        return peak(power, every, omega)


def _weighted(A: Complex, b: Array, weight: Array) -> Array:
    """Real taps of the smallest weighted sum of squares; a trace of ridge, for they are many."""
    normal = np.einsum("kmi,m,kmj->ij", A.conj(), weight, A, optimize=True).real
    right = np.einsum("kmi,m,km->i", A.conj(), weight, b, optimize=True).real
    ridge = 1e-12 * np.trace(normal) / len(normal)
    return np.linalg.solve(normal + ridge * np.eye(len(normal)), right)
