"""Speed that varies along a path: as fast as the limits allow at each place.

With x = v^2 on a grid of the arc length, the acceleration along the path is x' / 2 and its jerk
x'' v / 2. Limits of speed and acceleration, and those of the joints, are linear in x. That of jerk,
|x''| <= 2 jerk / v, is replaced by the tangent of its right side, which is below it everywhere:
each linear programme keeps the true limit, and its solution is where the next one is linearised.
The sum of x is maximised. Fan, Gao, Yan, Yuan, "Interactive programming of time-optimal feedrate",
IJAMT 62, 2012, maximise the same. That sum counts little what rest costs, and at rest the jerk
limits x'' no more: beside bends of some tenths of a millimetre its largest may rest at a point so
as to be faster around it. Such a path is solved again with the sum weighted as x shortens the time.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from .profile_grid import MOST, STANDSTILL, BoundsAt, Grid, nearly_at_rest
from .profile_program import GAP, LimitRows, Programme, largest, stacked
from .timing import PathLimits, Timing, profile_timing

ROUNDS = 3
"""Linear programmes, each from the solution of the one before."""
ROUGH = 1e-6
"""Gap of the programmes before the last, which only say where that is linearised."""
EXCESS = 1e-3
"""Relative excess of the jerk limit that counts as none."""
FASTER = 4.5e-3
"""Relative excess of a speed allowed that counts as none, 0.9 % of the acceleration in a bend."""
SAMPLES = 8
"""Places in each phase, about a step long, where that is looked at."""
START = 0.25
"""Speed at the end of the first phase, relative to the lowest one allowed near it."""
ATTEMPTS = 10
"""Most changes of the first phase, of the grid, or of the fraction of the jerk limit."""
TOGETHER = 3000
"""Grid points that are solved at once: memory does not grow with the number of paths, and a
programme of that size stays in a processor's cache."""


@dataclass(frozen=True)
class Profile:
    """Speed along a path, from rest to rest."""

    s: Array
    """(N,) [m], arc length."""
    speed: Array
    """(N,) [m/s]."""
    allowed: Array
    """(N,) [m/s], speed that was asked for, or less where a bend or a joint does not allow it."""
    timing: Timing
    rests: Array
    """(R,) [m], arc lengths where it all but rests although no limit asks for that."""


@dataclass(frozen=True)
class Bends:
    """A path of arcs and lines, and the limits of the joints along it."""

    lengths: Array
    curvature: Array
    """(E,) [m] and [1/m], of its elements."""
    bounds: BoundsAt | None = None


def profiles(paths: Sequence[Bends], speed: float, limits: PathLimits) -> list[Profile]:
    """Profile of each path, at most `speed` [m/s].

    Raises ValueError for a speed out of range, RuntimeError where no profile is found.
    """
    if not (np.isfinite(speed) and speed > 0.0):
        raise ValueError(f"speed must be > 0 m/s, got {speed}")
    grids = {i: _first_grid(path, speed, limits) for i, path in enumerate(paths)}
    found: dict[int, Profile] = {}
    for _ in range(ATTEMPTS):
        for batch in _batches(grids):
            solved = _solved([grids[i] for i in batch])
            for i, x in zip(batch, solved, strict=True):
                better = _judged(grids[i], x)
                if isinstance(better, Profile):
                    found[i] = better
                    del grids[i]
                else:
                    grids[i] = better
        if not grids:
            return [found[i] for i in range(len(paths))]
    length = next(iter(grids.values())).ends[-1]
    raise RuntimeError(f"no speed profile over {length:g} m at {speed:g} m/s")


def _first_grid(path: Bends, speed: float, limits: PathLimits) -> Grid:
    bend = np.maximum(np.abs(path.curvature), 1e-12)
    allowed = np.minimum(speed, np.sqrt(limits.acceleration / bend))
    ends = np.concatenate([[0.0], np.cumsum(path.lengths)])
    near = (ends[:-1] <= 0.1 * ends[-1]) | (ends[1:] >= 0.9 * ends[-1])
    # Of a first phase within a tenth of the length and 0.8 of the acceleration.
    steepest = 0.8 * limits.acceleration / limits.jerk
    longest = min((0.6 * float(ends[-1]) / limits.jerk) ** (1 / 3), steepest)
    return Grid(
        ends=ends,
        allowed=allowed,
        limits=limits,
        first=min(START * float(allowed[near].min()), 0.5 * limits.jerk * longest**2),
        fraction=0.95,
        bounds=path.bounds,
    )


def _batches(grids: dict[int, Grid]) -> Iterator[list[int]]:
    """Indices of grids that are solved at once: those with as many rows beside each other."""
    batch, points = list[int](), 0
    for i, grid in sorted(grids.items(), key=lambda each: len(each[1].fixed_rows.bound)):
        if batch and points + len(grid.s) > TOGETHER:
            yield batch
            batch, points = [], 0
        batch.append(i)
        points += len(grid.s)
    if batch:
        yield batch


def _judged(grid: Grid, x: Array | None) -> Profile | Grid:
    """The profile of a solution, or the grid of the next attempt."""
    if x is None:
        return replace(grid, first=0.5 * grid.first)
    if not grid.timed and nearly_at_rest(grid, x).any():
        return replace(grid, timed=True)
    found = _profile(grid, x)
    if len(grid.s) < MOST and _fastest(grid, found.timing) > 1.0 + FASTER:
        return replace(grid, spacing=0.5 * grid.spacing)
    excess = float(np.abs(found.timing.state[:, 3]).max()) / grid.limits.jerk
    return found if excess <= 1.0 + EXCESS else replace(grid, fraction=grid.fraction / excess)


def _fastest(grid: Grid, timing: Timing) -> float:
    """Highest speed anywhere, of the one allowed there: blends are faster than their points."""
    phases = np.diff(timing.start, append=timing.duration)
    parts = np.arange(SAMPLES)[:, None] / SAMPLES
    s, v, _ = timing.at((timing.start + parts * phases).ravel())
    element = np.clip(np.searchsorted(grid.ends, s) - 1, 0, len(grid.allowed) - 1)
    return float((v / grid.allowed[element]).max())


def _solved(grids: Sequence[Grid]) -> list[Array | None]:
    """x = v^2 at the points of each grid; None where the first phase is too fast."""
    if not (able := [grid for grid in grids if grid.possible]):
        return [None] * len(grids)
    sizes = np.array([len(grid.s) for grid in able])
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    held = np.concatenate([grid.held for grid in able])
    at: list[Array | None] = [None] * len(able)
    for round_ in range(ROUNDS):
        known = list(zip(able, at, strict=True))
        rows = _side_by_side([stacked([g.rows(x), g.fixed_rows]) for g, x in known], starts)
        weight = np.concatenate([g.weight(x) for g, x in known])
        begin = np.concatenate([g.start if x is None else x for g, x in known])
        gap = GAP if round_ == ROUNDS - 1 else ROUGH
        x, solved = largest(Programme.of(rows, starts, held, weight), begin, gap)
        for i, part in enumerate(np.split(x, starts[1:])):
            if solved[i] and (round_ == 0 or at[i] is not None):
                at[i] = np.maximum(part, 0.0)
    found = iter([None if x is None else g.unit * x for g, x in zip(able, at, strict=True)])
    return [next(found) if grid.possible else None for grid in grids]


def _side_by_side(rows: Sequence[LimitRows], starts: NDArray[np.int64]) -> LimitRows:
    """Rows of several grids as those of one; a kind that a grid lacks is no row there."""
    shape = max(len(own.bound) for own in rows), int(starts[-1]) + rows[-1].bound.shape[1]
    every = LimitRows(*[np.full(shape, empty) for empty in (0.0, 0.0, 0.0, np.inf)])
    for own, begin in zip(rows, starts, strict=True):
        height, width = own.bound.shape
        for whole, part in zip(every, own, strict=True):
            whole[:height, begin : begin + width] = part
    return every


def _profile(grid: Grid, x: Array) -> Profile:
    v, h = np.sqrt(x), grid.step
    steps = 2.0 * h / (v[:-1] + v[1:])
    timing = profile_timing(np.diff(x) / (2.0 * h), steps, grid.limits.jerk, grid.ramp)
    scale = grid.ends[-1] / timing.at(timing.duration)[0]  # blends shift it by nanometres
    timing = Timing(timing.start, scale * timing.state, timing.duration)
    ends = grid.ends[[0, -1]]
    s = np.concatenate([ends[:1], grid.s, ends[1:]])
    element = np.clip(np.searchsorted(grid.ends, s) - 1, 0, len(grid.allowed) - 1)
    allowed = grid.allowed[element]
    if grid.joints is not None:
        allowed[1:-1] = np.minimum(allowed[1:-1], grid.joints.speed)
    rests = grid.s[nearly_at_rest(grid, x) & (v < STANDSTILL * grid.caps.max())]
    return Profile(s, np.concatenate([[0.0], v, [0.0]]), allowed, timing, rests)
