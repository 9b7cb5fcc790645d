"""Linear programmes of speed profiles: the largest sum of x along many paths at once.

    maximise sum w x  subject to  lower_i x_(i-1) + middle_i x_i + upper_i x_(i+1) <= bound_i

for several rows at each point, with some x held. A row touches three points in a line, so that the
normal equations of an interior point method (Mehrotra, SIAM J. Optimization 2, 1992) are banded: a
step takes time in proportion to the number of points. Paths are independent and stand one after
the other, each with a step length and a barrier of its own.

Against HiGHS (`scipy.optimize.linprog`) on the programmes of sheets of 120 to 500 entities, 100
mm/s, one core, both to the same sum within 3e-6: its dual simplex takes 2.1 to 2.8 times as long, a
path at a time 4 to 7 times, its interior point method 6 to 7 times. The programmes are 40 % of a
plan's time, so that a part of 500 entities is planned in 4.4 s in place of 6.9 s. That holds for
sheets: on one small part, 26 contours at 200 mm/s (docs/examples/flange.dxf), HiGHS takes 0.9 times
as long. TOPP-RA solves limits of acceleration alone: rows of jerk touch three points.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

STEPS = 200
"""Most steps; 15 to 30 are usual, more where joints limit much of a path."""
GAP = 1e-9
"""Largest mean complementarity at the end, where x is of the order of 1."""
SOLVED = 0.4
"""Fraction of the points above which those of solved paths are left out."""
FEASIBLE = 1e-7
"""Largest violation of a row at the end."""
TO_BOUNDARY = 0.995
"""Fraction of the way to the boundary that a step may go."""
HELD = 1e20
"""Weight that holds a point."""
HEAVIEST = 1e14
"""Largest weight of a row, at which it holds as an equation."""
ROUNDING = 1e-12
"""Relative shift of the normal matrix's diagonal, by which it stays positive definite."""


class LimitRows(NamedTuple):
    """K rows for each point; one whose bound is infinite is none."""

    lower: Array
    middle: Array
    upper: Array
    bound: Array
    """(K, N) each, or (N,) of a single kind."""


def stacked(rows: Sequence[LimitRows]) -> LimitRows:
    """Rows of several kinds as one, (K, N)."""
    return LimitRows(*(np.vstack(parts) for parts in zip(*rows, strict=True)))


@dataclass(frozen=True, eq=False)
class Programme:
    """Rows of K kinds over the N points of M paths."""

    rows: LimitRows
    """(K, N) each, with finite bounds."""
    starts: NDArray[np.int64]
    """(M,), first point of each path."""
    held: NDArray[np.bool_]
    """(N,), points whose x stays."""
    weight: Array
    """(N,), of x in the sum."""

    @classmethod
    def of(
        cls,
        rows: LimitRows,
        starts: NDArray[np.int64],
        held: NDArray[np.bool_],
        weight: Array | None = None,
    ) -> "Programme":
        """Rows between two paths, and those of held points alone, must have an infinite bound.

        weight: (N,), of order 1; ones if None.
        """
        weight = np.ones(len(held)) if weight is None else weight
        *sides, bound = rows
        real = np.isfinite(bound)
        finite = [*(np.where(real, side, 0.0) for side in sides), np.where(real, bound, 1.0)]
        return cls(LimitRows(*finite), starts, held, weight)

    def of_paths(self, chosen: NDArray[np.bool_]) -> "Programme":
        """The rows of some paths (M,) alone."""
        points, sizes = self.per_path(chosen), self.sizes[chosen]
        rows = LimitRows(*(part[:, points] for part in self.rows))
        starts = np.cumsum(sizes) - sizes
        return Programme(rows, starts, self.held[points], self.weight[points])

    def times(self, x: Array) -> Array:
        """(K, N), left sides of all rows."""
        lower, middle, upper, _ = self.rows
        padded = np.concatenate([[0.0], x, [0.0]])
        return lower * padded[:-2] + middle * x + upper * padded[2:]

    def back(self, z: Array) -> Array:
        """(N,), the transposed product."""
        lower, middle, upper, _ = self.rows
        out = (middle * z).sum(axis=0)
        out[:-1] += (lower * z).sum(axis=0)[1:]
        out[1:] += (upper * z).sum(axis=0)[:-1]
        return out

    def normal(self, w: Array) -> Array:
        """(3, N), lower diagonals of the rows' weighted normal matrix."""
        a, b, c, _ = self.rows
        band = np.zeros((3, w.shape[1]))
        band[0] = (w * b * b).sum(axis=0)
        band[0, :-1] += (w * a * a).sum(axis=0)[1:]
        band[0, 1:] += (w * c * c).sum(axis=0)[:-1]
        band[1, :-1] = (w * b * c).sum(axis=0)[:-1]
        band[1, :-1] += (w * a * b).sum(axis=0)[1:]
        band[2, :-2] = (w * a * c).sum(axis=0)[1:-1]
        band[0] *= 1.0 + ROUNDING
        band[0, self.held] += HELD
        return band

    def per_path(self, values: NDArray[Any]) -> NDArray[Any]:
        """(N,), for each point a value of its path (M,)."""
        return np.repeat(values, self.sizes)

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """(M,), number of points of each path."""
        return np.diff(self.starts, append=len(self.held))

    @property
    def n_rows(self) -> NDArray[np.int64]:
        """(M,), number of rows of each path."""
        return self.sizes * len(self.rows.bound)


def largest(programme: Programme, x: Array, gap: float = GAP) -> tuple[Array, NDArray[np.bool_]]:
    """x (N,) of the largest weighted sum, and for each path (M,) whether it was found.

    x: where to start; held points keep it. gap: largest mean complementarity of what is found.
    """
    slack = np.maximum(programme.rows.bound - programme.times(x), 0.1)
    at = _Iterate(x, slack, np.full_like(slack, 1.0 / len(slack)))
    A, best, found = programme, x.copy(), np.zeros(len(programme.starts), dtype=bool)
    paths, points = np.arange(len(found)), np.arange(len(x))  # that A still has
    for _ in range(STEPS):
        state = at.state(A, gap)
        best[points], found[paths] = at.x, state.solved
        if state.solved.all():
            break
        if A.sizes[state.solved].sum() > SOLVED * len(at.x):
            left = ~state.solved
            rest = A.per_path(left)
            A, at, paths, points = A.of_paths(left), at.at(rest), paths[left], points[rest]
            state = at.state(A, gap)
        at = at.stepped(A, state)
    return best, found


class _State(NamedTuple):
    solved: NDArray[np.bool_]
    """(M,), each path."""
    mean: Array
    """(M,), complementarity."""
    primal: Array
    """(K, N), residual."""


@dataclass(frozen=True, eq=False)
class _Iterate:
    x: Array
    """(N,)."""
    slack: Array
    z: Array
    """(K, N) each, primal and dual."""

    def at(self, points: NDArray[np.bool_]) -> "_Iterate":
        """Some of the points (N,)."""
        return _Iterate(self.x[points], self.slack[:, points], self.z[:, points])

    def state(self, A: Programme, gap: float) -> _State:
        primal = A.times(self.x) + self.slack - A.rows.bound
        mean = np.add.reduceat((self.slack * self.z).sum(axis=0), A.starts) / A.n_rows
        worst = np.maximum.reduceat(np.abs(primal).max(axis=0), A.starts)
        return _State((mean < gap) & (worst < FEASIBLE), mean, primal)

    def stepped(self, A: Programme, state: _State) -> "_Iterate":
        """After a predictor and a corrector; solved paths stay."""
        from scipy.linalg import cho_solve_banded, cholesky_banded

        x, slack, z = self.x, self.slack, self.z
        solved, mean, primal = state
        dual = np.where(A.held, 0.0, A.back(z) - A.weight)
        moving = A.per_path(np.where(solved, 0.0, 1.0))
        weight = np.where(moving > 0.0, np.minimum(z / slack, HEAVIEST), 1.0)
        factor = cholesky_banded(A.normal(weight), lower=True, check_finite=False)

        def direction(complementarity: Array) -> tuple[Array, Array, Array]:
            """Newton step of x, slack and z."""
            right = -dual + A.back(complementarity / slack - weight * primal)
            right[A.held] = 0.0
            dx = cho_solve_banded((factor, True), right, check_finite=False)
            dx[A.held] = 0.0
            ds = -primal - A.times(dx)
            return dx, ds, -(complementarity + z * ds) / slack

        def lengths(step: tuple[Array, Array, Array], most: float) -> list[Array]:
            """Step lengths (N,) of each path, of x with slack and of z."""
            falls = [(-step[1] / slack).max(axis=0), (-step[2] / z).max(axis=0)]
            fastest = [np.maximum(np.maximum.reduceat(fall, A.starts), 1e-300) for fall in falls]
            return [A.per_path(np.minimum(1.0, most / each)) for each in fastest]

        # Predictor: straight to complementarity of zero.
        step = direction(slack * z)
        length = lengths(step, 1.0)
        after = (slack + length[0] * step[1]) * (z + length[1] * step[2])
        reached = np.add.reduceat(after.sum(axis=0), A.starts) / A.n_rows
        target = A.per_path(mean * np.clip(reached / np.maximum(mean, 1e-300), 0.0, 1.0) ** 3)
        step = direction(slack * z + step[1] * step[2] - target)
        along, beside = (moving * each for each in lengths(step, TO_BOUNDARY))
        return _Iterate(x + along * step[0], slack + along * step[1], z + beside * step[2])
