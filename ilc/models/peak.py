"""Largest value over frequency of the squared size of a rational response, with a guaranteed bound.

Let p_k be the poles of a response of order n, poles at the origin for a longer numerator included.
Its squared size t >= 0 changes at most at the pace of the phase of the all-pass with these poles,

    |t'| <= Theta' sqrt(t (M - t)),    Theta' = sum_k (1 - |p_k|^2) / |e^{j omega} - p_k|^2,

M = sup t, the inequality of Bernstein for rational functions (Videnskii; Borwein and Erdelyi,
Polynomials and Polynomial Inequalities, 7.1). A grid with steps h of Theta therefore finds at least
cos^2(h / 4) of the largest value, however narrow a resonance is, and intervals that may hold more
are halved. For a matrix t is the largest singular value squared, and all entries have their poles
counted.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from .system import Complex

SPACING = 0.1
"""Step of a first grid in the phase of the all-pass [rad]: finds all but 0.06 % of the largest
square."""
_TIGHT = 1e-9  # relative width of the bound that is enough
_ROUNDS, _MOST = 20, 1 << 14  # halvings and points at most; flat tops and rounding need no more
_INSIDE = 1.0 - 1e-13  # modulus of a computed pole at most


@dataclass(frozen=True, eq=False)
class AllPassPhase:
    """Phase Theta of the all-pass with some poles, over omega in [0, pi] [rad/sample]."""

    poles: Complex
    """Inside the unit circle, complex ones with their conjugates."""

    def __call__(self, omega: Array) -> Array:
        omega, poles = np.asarray(omega), self.poles[self.poles != 0.0]
        radius, angle = np.minimum(np.abs(poles), _INSIDE), np.angle(poles)
        half = 0.5 * (omega[..., None] - angle)
        slope = (1.0 + radius) / (1.0 - radius)
        turns = 2.0 * np.arctan2(slope * np.sin(half), np.cos(half))
        return turns.sum(axis=-1) + (len(self.poles) - len(poles)) * omega

    def grid(self, spacing: float = SPACING) -> Array:
        """Frequencies from 0 to pi with steps of about `spacing` in Theta."""
        width = np.maximum(1.0 - np.abs(self.poles), 1.0 - _INSIDE)
        near = np.tan(np.linspace(-1.55, 1.55, 64)) * width[:, None]
        around = np.clip((np.angle(self.poles)[:, None] + near).ravel(), 0.0, np.pi)
        coarse = np.unique(np.concatenate((np.linspace(0.0, np.pi, 200), around)))
        theta = self(coarse)
        count = int(np.ceil((theta[-1] - theta[0]) / spacing)) + 1
        return np.unique(np.interp(np.linspace(theta[0], theta[-1], count), theta, coarse))


@dataclass(frozen=True, eq=False)
class Peak:
    """Squared sizes (M,) at the frequencies omega (M,), and an upper bound of all of them."""

    omega: Array
    values: Array
    bound: float


def peak(power: Callable[[Array], Array], poles: Complex, first: Array | None = None) -> Peak:
    """Largest value of `power` over [0, pi], located by branch and bound.

    power: omega (M,) to squared sizes (M,), >= 0. first: frequencies that are evaluated anyway.
    """
    phase = AllPassPhase(poles)
    omega = np.unique(np.concatenate((phase.grid(), [0.0, np.pi] if first is None else first)))
    values, theta = power(omega), phase(omega)
    known = [(omega, values)]
    # (2, intervals): left and right end of each interval that may hold more than was found
    ends = [np.stack((each[:-1], each[1:])) for each in (omega, values, theta)]
    best = float(values.max())
    M = best / np.cos(0.25 * min(float(np.diff(theta).max()), 3.0)) ** 2
    for halving in range(_ROUNDS + 1):
        bounds = _interval_bounds(ends[1], ends[2][1] - ends[2][0], M)
        M = max(float(bounds.max(initial=0.0)), (1.0 + _TIGHT) * best)
        unsure = bounds > (1.0 + _TIGHT) * best
        if not unsure.any() or unsure.sum() > _MOST or halving == _ROUNDS:
            break
        ends = [each[:, unsure] for each in ends]
        middle = ends[0].mean(axis=0)
        there = power(middle)
        known.append((middle, there))
        best = max(best, float(there.max()))
        inserted = zip(ends, (middle, there, phase(middle)), strict=True)
        ends = [
            np.concatenate((np.stack((each[0], new)), np.stack((new, each[1]))), axis=1)
            for each, new in inserted
        ]
    omega, values = (np.concatenate(part) for part in zip(*known, strict=True))
    order = np.argsort(omega)
    return Peak(omega[order], values[order], M)


def _interval_bounds(values: Array, step: Array, M: float) -> Array:
    """Upper bound of t between ends (2, intervals): t = M cos^2(phi / 2) with |phi'| <= Theta'."""
    if not M > 0.0:
        return np.zeros_like(step)
    phi = 2.0 * np.arccos(np.sqrt(np.clip(values / M, 0.0, 1.0)))
    least = np.maximum(0.5 * (phi.sum(axis=0) - step), 0.0)
    return M * np.cos(0.5 * least) ** 2
