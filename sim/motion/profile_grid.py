"""Grid of one path, on which its speed profile is a linear programme."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from .profile_program import LimitRows, stacked
from .timing import PathLimits

STEP = 0.4e-3
"""Distance of grid points along the path [m], less where blends of steps are too fast."""
FEWEST, MOST = 60, 2000
"""Number of grid points."""
LEAST_LEFT = 0.5
"""Fraction of x = v^2 that a programme of the time leaves of the one before."""
SLACK = 0.5
"""Fraction of the lowest speed allowed within reach of a place that it need not fall below."""
STANDSTILL = 0.01
"""Fraction of a path's highest speed that counts as rest."""


class Bounds(NamedTuple):
    """Limits of the joints at places of a path, |along s'' + bend s'^2 + offset| <= 1 each."""

    speed: Array
    """(N,) [m/s], at most."""
    along: Array
    """(N, J) [s^2/m]."""
    bend: Array
    """(N, J) [s^2/m^2]."""
    offset: Array
    """(N, J)."""

    @property
    def steady(self) -> Array:
        """(N,) [m/s], highest speed that the joints can hold."""
        # The side that the bend drives to: sign(bend) (bend s'^2 + offset) <= 1.
        sign, size = np.sign(self.bend), np.abs(self.bend)
        most = np.full_like(size, np.inf)
        np.divide(1.0 - sign * self.offset, size, out=most, where=size > 0.0)
        return np.minimum(self.speed, np.sqrt(np.maximum(most.min(axis=1), 0.0)))


BoundsAt = Callable[[Array], Bounds]
"""Limits of the joints at arc lengths (N,) [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Points between a first and a last phase of constant jerk."""

    ends: Array
    """(E + 1,) [m], arc length at the ends of the path's elements."""
    allowed: Array
    """(E,) [m/s], on each element."""
    limits: PathLimits
    first: float
    """Speed after the first phase and before the last [m/s]."""
    fraction: float
    """Of the jerk limit that the linear programme may use."""
    bounds: BoundsAt | None = None
    spacing: float = STEP
    """Of the points [m], where neither their fewest nor their most say another."""
    timed: bool = False
    """Whether the sum of x is weighted as it shortens the time."""

    @property
    def ramp(self) -> float:
        """Duration of the first phase [s]."""
        return float(np.sqrt(2.0 * self.first / self.limits.jerk))

    @cached_property
    def s(self) -> Array:
        """(N,) [m]."""
        inset = self.limits.jerk * self.ramp**3 / 6.0
        length = self.ends[-1] - 2.0 * inset
        return inset + length * np.linspace(
            0.0, 1.0, int(np.clip(length / self.spacing, FEWEST, MOST))
        )

    @property
    def step(self) -> float:
        """[m]."""
        return float(self.s[1] - self.s[0])

    @cached_property
    def caps(self) -> Array:
        """(N,) [m/s], the lowest speed allowed from the grid point before to the one after."""
        element = np.searchsorted(self.ends, [self.s - self.step, self.s + self.step]) - 1
        before, after = np.clip(element, 0, len(self.allowed) - 1)
        caps = self.allowed[after].copy()
        for more in range(int((after - before).max(initial=0)) + 1):
            caps = np.minimum(caps, self.allowed[np.minimum(before + more, after)])
        return caps if self.joints is None else np.minimum(caps, self.joints.speed)

    @cached_property
    def joints(self) -> Bounds | None:
        """Limits of the joints at the points."""
        return None if self.bounds is None else self.bounds(self.s)

    @cached_property
    def unit(self) -> float:
        """[m^2/s^2], of the programme's variable."""
        return float(self.caps.max() ** 2)

    @cached_property
    def start(self) -> Array:
        """(N,), x over its unit where the programme starts; two points at each end are held."""
        x = 0.25 * self.caps**2
        rising = 2.0 * self.step * self.limits.jerk * self.ramp
        x[[0, -1]], x[[1, -2]] = self.first**2, self.first**2 + rising
        return x / self.unit

    @property
    def possible(self) -> bool:
        """The held points are within their limits."""
        return bool((self.start <= self.caps**2 / self.unit)[[0, 1, -2, -1]].all())

    @cached_property
    def held(self) -> np.ndarray:
        """(N,) bool."""
        held = np.zeros(len(self.s), dtype=bool)
        held[[0, 1, -2, -1]] = True
        return held

    @cached_property
    def fixed_rows(self) -> LimitRows:
        """Limits of speed, of acceleration, and of the joints."""
        n, one, none = len(self.s), np.ones(len(self.s)), np.zeros(len(self.s))
        free = ~self.held
        most = np.where(free, self.caps**2 / self.unit, np.inf)
        steepest = np.full(n, 2.0 * self.step * self.limits.acceleration / self.unit)
        steepest[[0, -2, -1]] = np.inf
        found = (
            LimitRows(none, one, none, most),
            LimitRows(none, -one, none, np.where(free, 0.0, np.inf)),
            LimitRows(none, -one, one, steepest),
            LimitRows(none, one, -one, steepest),
        )
        return stacked(found if self.joints is None else (*found, self._joint_rows(self.joints)))

    def _joint_rows(self, joints: Bounds) -> LimitRows:
        """Limits of joints, at each point those that speed and acceleration can come to."""
        unit = self.unit
        bend, offset = joints.bend * self.caps[:, None] ** 2, joints.offset
        reach = np.abs(joints.along) * self.limits.acceleration
        signs = np.repeat([1.0, -1.0], joints.along.shape[1])
        most = [reach + np.maximum(sign * bend, 0.0) + sign * offset for sign in (1.0, -1.0)]
        near = (np.hstack(most) > 1.0) & ~self.held[:, None]
        # Few limits are near at one place: the k-th row of a point is the k-th of those.
        chosen = np.argsort(~near, axis=1, kind="stable")[:, : near.sum(axis=1).max()]
        slope, bend, offset = (
            np.take_along_axis(np.hstack([part, part]), chosen, axis=1).T * signs[chosen].T
            for part in (joints.along * unit / (4.0 * self.step), joints.bend * unit, joints.offset)
        )
        size = np.maximum(1.0, 2.0 * np.abs(slope) + np.abs(bend))  # rows of order 1
        used = np.take_along_axis(near, chosen, axis=1).T
        bound = np.where(used, (1.0 - offset) / size, np.inf)
        slope, bend = slope / size, bend / size
        return LimitRows(-slope, bend, slope, bound)

    def weight(self, x: Array | None) -> Array:
        """(N,), of x in the sum. The time falls by x^(-3/2) / 2 with x, here that at x or caps."""
        if not self.timed:
            return np.ones(len(self.s))
        caps = self.caps**2 / self.unit
        slope = (caps if x is None else np.maximum(x, 1e-3 * caps)) ** -1.5
        return slope / slope.mean()

    def rows(self, x: Array | None) -> LimitRows:
        """Those that change with x (N,), over its unit, of the programme before; None for none."""
        jerk = self.jerk_rows(x)
        if x is None or not self.timed:
            return jerk
        none = np.zeros_like(x)
        floor = np.where(self.held, np.inf, -LEAST_LEFT * x)
        return stacked([jerk, LimitRows(none, none - 1.0, none, floor)])

    def jerk_rows(self, x: Array | None) -> LimitRows:
        """Limit of jerk, linearised at x (N,) over its unit; at the caps if None."""
        at = np.maximum(self.caps**2 if x is None else x * self.unit, 1e-12)
        jerk = self.fraction * self.limits.jerk * self.step**2
        falling = np.zeros_like(at) if x is None else jerk / at**1.5
        bound = (2.0 if x is None else 3.0) * jerk / np.sqrt(at) / self.unit
        bound[[0, -1]] = np.inf
        one = np.ones_like(at)
        rising = LimitRows(one, falling - 2.0, one, bound)
        return stacked([rising, LimitRows(-one, falling + 2.0, -one, bound)])


def nearly_at_rest(grid: Grid, x: Array) -> NDArray[np.bool_]:
    """(N,), points of a grid whose speed is below `SLACK` of one that could be held there.

    The lowest speed allowed within the length of a ramp to the highest can be held over all of it;
    the ramps at both ends are left out. x: (N,) [m^2/s^2].
    """
    from scipy.ndimage import minimum_filter1d

    allowed = grid.caps
    if grid.joints is not None:
        allowed = np.minimum(allowed, grid.joints.steady)
    reach = int(grid.limits.ramp_length(float(grid.caps.max())) / grid.step) + 1
    lowest = minimum_filter1d(allowed, 2 * reach + 1)
    peak = np.minimum(grid.limits.acceleration, np.sqrt(grid.limits.jerk * lowest))
    ramp = 0.5 * lowest * (lowest / np.maximum(peak, 1e-12) + peak / grid.limits.jerk)
    from_end = np.minimum(grid.s, grid.ends[-1] - grid.s)
    return (np.sqrt(x) < SLACK * lowest) & (from_end > 2.0 * ramp) & ~grid.held
