"""Speed that varies along a path: as fast as the limits allow at each place.

With x = v^2 on a grid of the arc length, the acceleration along the path is x' / 2 and its jerk
x'' v / 2. Limits of speed and acceleration are linear in x. That of jerk, |x''| <= 2 jerk / v,
is replaced by the tangent of its right side, which is below it everywhere: each linear programme
keeps the true limit, and its solution is where the next one is linearised. The sum of x is
maximised. Fan, Gao, Yan, Yuan, "Interactive programming of time-optimal feedrate", IJAMT 62, 2012,
maximise the same.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_array, diags, vstack

from armside.arrays import Array

from .timing import PathLimits, Timing

STEP = 0.4e-3
"""Distance of grid points along the path [m]."""
FEWEST, MOST = 60, 2000
"""Number of grid points."""
ROUNDS = 3
"""Linear programmes, each from the solution of the one before."""
EXCESS = 1e-3
"""Relative excess of the jerk limit that counts as none."""
START = 0.25
"""Speed at the end of the first phase, relative to the lowest one allowed near it."""


@dataclass(frozen=True)
class Profile:
    """Speed along a path, from rest to rest."""

    s: Array
    """(N,) [m], arc length."""
    speed: Array
    """(N,) [m/s]."""
    allowed: Array
    """(N,) [m/s], speed that was asked for, or less where a bend does not allow it."""
    timing: Timing


def profile(lengths: Array, curvature: Array, speed: float, limits: PathLimits) -> Profile:
    """Profile along elements of `lengths` [m] and `curvature` [1/m], at most `speed` [m/s].

    Raises ValueError for a speed out of range, RuntimeError where no profile is found.
    """
    if not (np.isfinite(speed) and speed > 0.0):
        raise ValueError(f"speed must be > 0 m/s, got {speed}")
    bend = np.maximum(np.abs(curvature), 1e-12)
    allowed = np.minimum(speed, np.sqrt(limits.acceleration / bend))
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    first = START * min(_lowest(ends, allowed, 0.0, 0.1), _lowest(ends, allowed, 0.9, 1.0))
    first, share = min(first, _fastest_start(float(ends[-1]), limits)), 0.95
    for _ in range(8):
        grid = _Grid(ends, allowed, limits, first, share)
        x = grid.solved()
        if x is None:
            first *= 0.5
            continue
        found = grid.profile(x)
        excess = float(np.abs(found.timing.state[:, 3]).max()) / limits.jerk
        if excess <= 1.0 + EXCESS:
            return found
        share /= excess
    raise RuntimeError(f"no speed profile over {ends[-1]:g} m at {speed:g} m/s")


def _lowest(ends: Array, allowed: Array, lower: float, upper: float) -> float:
    inside = (ends[1:] >= lower * ends[-1]) & (ends[:-1] <= upper * ends[-1])
    return float(allowed[inside].min())


def _fastest_start(length: float, limits: PathLimits) -> float:
    """Speed [m/s] of a first phase within a tenth of the length and 0.8 of the acceleration."""
    longest = min((0.6 * length / limits.jerk) ** (1 / 3), 0.8 * limits.acceleration / limits.jerk)
    return 0.5 * limits.jerk * longest**2


@dataclass(frozen=True)
class _Grid:
    """Linear programme between a first and a last phase of constant jerk."""

    ends: Array
    allowed: Array
    limits: PathLimits
    first: float
    """Speed after the first phase and before the last [m/s]."""
    share: float
    """Fraction of the jerk limit that the linear programme may use."""

    @property
    def ramp(self) -> float:
        """Duration of the first phase [s]."""
        return float(np.sqrt(2.0 * self.first / self.limits.jerk))

    @cached_property
    def s(self) -> Array:
        inset = self.limits.jerk * self.ramp**3 / 6.0
        length = self.ends[-1] - 2.0 * inset
        return inset + length * np.linspace(0.0, 1.0, int(np.clip(length / STEP, FEWEST, MOST)))

    @property
    def step(self) -> float:
        return float(self.s[1] - self.s[0])

    @cached_property
    def caps(self) -> Array:
        """[m/s], the lowest speed allowed from the grid point before to the one after."""
        element = np.searchsorted(self.ends, [self.s - self.step, self.s + self.step]) - 1
        before, after = np.clip(element, 0, len(self.allowed) - 1)
        return np.array([self.allowed[i : j + 1].min() for i, j in zip(before, after, strict=True)])

    def solved(self) -> Array | None:
        """x = v^2 at the grid points; None if the first phase is too fast."""
        x = self.caps**2
        unit, h, jerk = float(x.max()), self.step, self.share * self.limits.jerk
        n = len(x)
        slope = diags([-np.ones(n - 1), np.ones(n - 1)], offsets=(0, 1), shape=(n - 1, n))  # pyright: ignore[reportArgumentType]
        bending = _second(n)
        start = self.limits.jerk * self.ramp
        steepest = np.full(n - 1, 2.0 * h * self.limits.acceleration)
        upper, lower = steepest.copy(), -steepest
        # The first and last interval go on as the phases beside them end.
        upper[0] = lower[0] = 2.0 * h * start
        upper[-1], lower[-1] = -lower[0], -upper[0]
        bounds = np.column_stack([np.zeros(n), x])
        bounds[[0, -1]] = self.first**2
        if self.first**2 > min(x[0], x[-1]):
            return None
        for round_ in range(ROUNDS):
            inside = np.maximum(x[1:-1], 1e-12)
            if round_ == 0:
                constant, falling = 2.0 * jerk * h**2 / np.sqrt(inside), 0.0 * inside
            else:
                constant = 3.0 * jerk * h**2 / np.sqrt(inside)
                falling = jerk * h**2 / inside**1.5
            middle = diags([falling], offsets=(1,), shape=(n - 2, n))  # pyright: ignore[reportArgumentType]
            rows = vstack([slope, -slope, bending + middle, middle - bending])
            most = np.concatenate([upper, -lower, constant, constant])
            found = linprog(
                -np.ones(n), A_ub=csr_array(rows), b_ub=most / unit, bounds=bounds / unit
            )
            if found.x is None:
                return None if round_ == 0 else x
            x = unit * found.x
        return x

    def profile(self, x: Array) -> Profile:
        v, h = np.sqrt(x), self.step
        steps = 2.0 * h / (v[:-1] + v[1:])
        timing = _timing(np.diff(x) / (2.0 * h), steps, self.limits.jerk, self.ramp)
        scale = self.ends[-1] / timing.at(timing.duration)[0]  # blends shift it by nanometres
        timing = Timing(timing.start, scale * timing.state, timing.duration)
        ends = self.ends[[0, -1]]
        s = np.concatenate([ends[:1], self.s, ends[1:]])
        element = np.clip(np.searchsorted(self.ends, s) - 1, 0, len(self.allowed) - 1)
        return Profile(s, np.concatenate([[0.0], v, [0.0]]), self.allowed[element], timing)


def _timing(acceleration: Array, steps: Array, jerk: float, ramp: float) -> Timing:
    """Phases of constant jerk: ramps at both ends, and between them `acceleration` for `steps` [s].

    Each change of acceleration is spread over half of the shorter step before and after it.
    """
    half = np.concatenate([[0.0], 0.5 * np.minimum(steps[:-1], steps[1:]), [0.0]])
    knots = ramp + np.concatenate([[0.0], np.cumsum(steps)])
    change = np.diff(acceleration)
    held = np.column_stack([knots[:-1] + half[:-1], np.zeros(len(steps))])
    blends = np.column_stack([knots[1:-1] - half[1:-1], change / (2.0 * half[1:-1])])
    phases = np.empty((2 * len(steps) - 1, 2))
    phases[::2], phases[1::2] = held, blends
    start = np.concatenate([[0.0], phases[:, 0], knots[-1:]])
    phase_jerk = np.concatenate([[jerk], phases[:, 1], [jerk]])
    length = np.diff(start, append=knots[-1] + ramp)
    state = np.zeros((len(start), 4))
    state[:, 3] = phase_jerk
    for k, h in enumerate(length[:-1]):
        s, v, a, j = state[k]
        moved = s + h * (v + h * (a / 2 + h * j / 6))
        state[k + 1, :3] = moved, v + h * (a + h * j / 2), a + h * j
    return Timing(start, state, float(knots[-1] + ramp))


def _second(n: int) -> csr_array:
    """Second differences (n - 2, n)."""
    one = np.ones(n - 2)
    return csr_array(diags([one, -2.0 * one, one], offsets=(0, 1, 2), shape=(n - 2, n)))  # pyright: ignore[reportArgumentType]
