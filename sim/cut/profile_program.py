"""Linear programmes of speed profiles: the largest sum of x along many paths at once.

    maximise sum x  subject to  lower_i x_(i-1) + middle_i x_i + upper_i x_(i+1) <= bound_i

for several rows at each point, with some x held. A row touches three points in a line, so that the
normal equations of an interior point method (Mehrotra, SIAM J. Optimization 2, 1992) are banded: a
step takes time in proportion to the number of points. Paths are independent and stand one after
the other, each with a step length and a barrier of its own.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from armside.arrays import Array

STEPS = 200
"""Most steps; 15 to 30 are usual, more where joints limit much of a path."""
GAP = 1e-9
"""Largest mean complementarity at the end, where x is of the order of 1."""
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


@dataclass(frozen=True, eq=False)
class Rows:
    """One row for each point; one whose bound is infinite is none."""

    lower: Array
    middle: Array
    upper: Array
    bound: Array
    """(N,) each."""


@dataclass(frozen=True, eq=False)
class Programme:
    """Rows of K kinds over the N points of M paths."""

    lower: Array
    middle: Array
    upper: Array
    bound: Array
    """(K, N) each."""
    starts: NDArray[np.int64]
    """(M,), first point of each path."""
    held: NDArray[np.bool_]
    """(N,), points whose x stays."""

    @classmethod
    def of(
        cls, rows: list[Rows], starts: NDArray[np.int64], held: NDArray[np.bool_]
    ) -> "Programme":
        """Rows between two paths, and those of held points alone, must have an infinite bound."""
        used = [np.stack([getattr(row, n) for row in rows]) for n in ("lower", "middle", "upper")]
        bound = np.stack([row.bound for row in rows])
        real = np.isfinite(bound)
        lower, middle, upper = (np.where(real, part, 0.0) for part in used)
        return cls(lower, middle, upper, np.where(real, bound, 1.0), starts, held)

    def times(self, x: Array) -> Array:
        """(K, N), left sides of all rows."""
        padded = np.concatenate([[0.0], x, [0.0]])
        return self.lower * padded[:-2] + self.middle * x + self.upper * padded[2:]

    def back(self, z: Array) -> Array:
        """(N,), the transposed product."""
        out = (self.middle * z).sum(axis=0)
        out[:-1] += (self.lower * z).sum(axis=0)[1:]
        out[1:] += (self.upper * z).sum(axis=0)[:-1]
        return out

    def normal(self, w: Array) -> Array:
        """(3, N), lower diagonals of the rows' weighted normal matrix."""
        a, b, c = self.lower, self.middle, self.upper
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

    def per_path(self, values: Array) -> Array:
        """(N,), for each point a value of its path (M,)."""
        return np.repeat(values, self.sizes)

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """(M,), number of points of each path."""
        return np.diff(self.starts, append=self.bound.shape[1])


def largest(programme: Programme, x: Array) -> tuple[Array, NDArray[np.bool_]]:
    """x (N,) of the largest sum, and for each path (M,) whether it was found.

    x: where to start; held points keep it.
    """
    A, starts = programme, programme.starts
    count = A.sizes * len(A.bound)
    slack = np.maximum(A.bound - A.times(x), 0.1)
    z = np.full_like(slack, 1.0 / len(A.bound))
    found = np.zeros(len(starts), dtype=bool)
    for _ in range(STEPS):
        dual = np.where(A.held, 0.0, A.back(z) - 1.0)
        primal = A.times(x) + slack - A.bound
        gap = np.add.reduceat((slack * z).sum(axis=0), starts) / count
        worst = np.maximum.reduceat(np.abs(primal).max(axis=0), starts)
        found = (gap < GAP) & (worst < FEASIBLE)
        if found.all():
            break
        moving = A.per_path(np.where(found, 0.0, 1.0))
        weight = np.where(moving > 0.0, np.minimum(z / slack, HEAVIEST), 1.0)
        factor = cholesky_banded(A.normal(weight), lower=True, check_finite=False)
        # Predictor: straight to complementarity of zero.
        step = _direction(A, factor, weight, slack, z, dual, primal, slack * z)
        length = _length(A, slack, z, step, 1.0)
        after = (slack + length[0] * step[1]) * (z + length[1] * step[2])
        reached = np.add.reduceat(after.sum(axis=0), starts) / count
        target = A.per_path(gap * np.clip(reached / np.maximum(gap, 1e-300), 0.0, 1.0) ** 3)
        step = _direction(
            A, factor, weight, slack, z, dual, primal, slack * z + step[1] * step[2] - target
        )
        along, beside = _length(A, slack, z, step, TO_BOUNDARY)
        x = x + moving * along * step[0]
        slack = slack + moving * along * step[1]
        z = z + moving * beside * step[2]
    return x, found


def _direction(
    A: Programme,
    factor: Array,
    weight: Array,
    slack: Array,
    z: Array,
    dual: Array,
    primal: Array,
    complementarity: Array,
) -> tuple[Array, Array, Array]:
    """Newton step of x, slack and z. factor: of the normal matrix, by Cholesky."""
    right = -dual + A.back(complementarity / slack - weight * primal)
    right[A.held] = 0.0
    dx = cho_solve_banded((factor, True), right, check_finite=False)
    dx[A.held] = 0.0
    ds = -primal - A.times(dx)
    return dx, ds, -(complementarity + z * ds) / slack


def _length(
    A: Programme, slack: Array, z: Array, step: tuple[Array, Array, Array], most: float
) -> tuple[Array, Array]:
    """Step lengths (N,) of each path, of x with slack and of z."""
    lengths = []
    for value, change in ((slack, step[1]), (z, step[2])):
        fastest = np.maximum.reduceat((-change / value).max(axis=0), A.starts)
        lengths.append(A.per_path(np.minimum(1.0, most / np.maximum(fastest, 1e-300))))
    return lengths[0], lengths[1]
