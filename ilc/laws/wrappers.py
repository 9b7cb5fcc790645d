"""Laws around another law."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array, check_numbers

from ..filters import ALL_PASS, RecordFilter
from ..records import records
from .first_order import FirstOrderLaw, Law


@dataclass(frozen=True, kw_only=True)
class Scheduled:
    """Law chosen by iteration, such as a falling gain or a rising cutoff; the last one stays."""

    laws: tuple[FirstOrderLaw, ...]
    """First-order laws for the updates after k = 0, 1, ..."""

    def __post_init__(self) -> None:
        if not self.laws:
            raise ValueError("laws must hold at least one law")

    def check(self, n_samples: int, n_columns: int) -> None:
        for law in self.laws:
            law.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def step(
        self, correction: Array, error: Array, memory: int | None = None, /
    ) -> tuple[Array, int]:
        k = memory or 0
        return self.laws[min(k, len(self.laws) - 1)](correction, error), k + 1


@dataclass(frozen=True, eq=False)
class Around:
    """Law that learns a change of a correction (N, n) that is there already, such as a model's.

    u_{k+1} = u_c + law(u_k - u_c, e_k): a filter Q of the law takes nothing from u_c.
    """

    law: Law
    centre: Array = field(repr=False)

    def check(self, n_samples: int, n_columns: int) -> None:
        if self.centre.shape != (n_samples, n_columns):
            needed = f"the shape {(n_samples, n_columns)} of the record"
            raise ValueError(f"centre must have {needed}, got {self.centre.shape}")
        self.law.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def step(self, correction: Array, error: Array, memory: Any = None, /) -> tuple[Array, Any]:
        change, memory = self.law.step(correction - self.centre, error, memory)
        return self.centre + change, memory


class Best(NamedTuple):
    """Best iteration so far, and the step length from it."""

    correction: Array
    error: Array
    size: float
    gain: float
    setbacks: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Guarded:
    """Law with backtracking: a step is kept only if the error does not grow.

    After an error above `tolerance` times the smallest, the next iteration starts from the best
    correction with `back_off` times the last step; after `patience` of these it is repeated.
    """

    law: FirstOrderLaw
    weight: tuple[float, ...]
    """(p,), weights of the error's columns in its size; 0 leaves one out."""
    tolerance: float = 1.2
    """Above 1, so that measurement noise is not taken for growth."""
    back_off: float = 0.5
    patience: int = 3

    def __post_init__(self) -> None:
        check_numbers(self, "tolerance", "back_off", "patience")
        check_numbers(self, "weight", several=True)
        if not self.tolerance >= 1.0:
            raise ValueError(f"tolerance must be >= 1, got {self.tolerance}")
        if not 0.0 < self.back_off < 1.0:
            raise ValueError(f"back_off must be in (0, 1), got {self.back_off}")
        if self.patience < 1:
            raise ValueError(f"patience must be >= 1, got {self.patience}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.law.check(n_samples, n_columns)

    @records("error")
    def size(self, error: Array) -> float:
        """Weighted RMS of an error."""
        return float(np.sqrt(np.square(error * np.array(self.weight)).sum(axis=1).mean()))

    @records("correction", "error", alike=False)
    def step(
        self, correction: Array, error: Array, memory: Best | None = None, /
    ) -> tuple[Array, Best]:
        size = self.size(error)
        if memory is None:
            memory = Best(correction, error, size, 1.0, 0)
        elif size <= memory.size:
            memory = Best(correction, error, size, memory.gain, memory.setbacks)
        elif size > self.tolerance * memory.size:
            memory = memory._replace(gain=memory.gain * self.back_off, setbacks=memory.setbacks + 1)
            correction, error = memory.correction, memory.error
        if memory.setbacks >= self.patience:
            return memory.correction, memory
        wanted = self.law(correction, error)
        return correction + memory.gain * (wanted - correction), memory


class SegmentMemory(NamedTuple):
    """State of the segments before an update."""

    inner: Any
    """Memory of the law."""
    best: Array
    """(N, n), correction of each segment's best iteration; size (M,) of its error."""
    size: Array
    stalls: NDArray[np.int64]
    """(M,) updates running that brought little; held (M,): it keeps its best correction."""
    held: NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class BySegment:
    """Law for records of M segments, each of which ends its learning when it has converged.

    A segment whose error falls by less than `least` in `patience` updates running keeps the
    correction of its best iteration, while the others learn on. Segments are blended where one
    follows the other.
    """

    law: Law
    weight: Array = field(repr=False)
    """(N, M), of each segment in the correction at each sample; rows sum to 1."""
    judged: tuple[tuple[int, int], ...]
    """(M,) first sample and the one after the last, by whose error a segment is judged."""
    size_of: Callable[[Array], Array]
    """Sizes of an error (K, p)."""
    least: float = 0.1
    patience: int = 2

    def __post_init__(self) -> None:
        if not 0.0 < self.least < 1.0:
            raise ValueError(f"least must be between 0 and 1, got {self.least}")
        if self.patience < 1:
            raise ValueError(f"patience must be >= 1, got {self.patience}")
        if self.weight.ndim != 2 or self.weight.shape[1] != len(self.judged):
            raise ValueError(f"weight must be (N, {len(self.judged)}), got {self.weight.shape}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.weight) != n_samples:
            raise ValueError(f"weight must have {n_samples} rows, got {len(self.weight)}")
        self.law.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def step(
        self, correction: Array, error: Array, memory: SegmentMemory | None = None, /
    ) -> tuple[Array, SegmentMemory]:
        sizes = [np.linalg.norm(self.size_of(error[first:last])) for first, last in self.judged]
        seen = self._seen(correction, np.array(sizes, dtype=np.float64), memory)
        wanted, inner = self.law.step(correction, error, seen.inner)
        kept = (self.weight @ seen.held.astype(np.float64))[:, np.newaxis]
        return wanted + kept * (seen.best - wanted), seen._replace(inner=inner)

    def _seen(self, u: Array, size: Array, memory: SegmentMemory | None) -> SegmentMemory:
        """The memory with one more run in it."""
        if memory is None:
            none = np.zeros(len(size), dtype=np.int64)
            return SegmentMemory(None, u, size, none, none.astype(bool))
        stalls = np.where(size > (1.0 - self.least) * memory.size, memory.stalls + 1, 0)
        better = (size < memory.size) & ~memory.held
        moved = (self.weight @ better.astype(np.float64))[:, np.newaxis]
        return SegmentMemory(
            inner=memory.inner,
            best=memory.best + moved * (u - memory.best),
            size=np.where(better, size, memory.size),
            stalls=np.where(memory.held, memory.stalls, stalls),
            held=memory.held | (stalls >= self.patience),
        )


_FRUITLESS = 3
"""Passes without a smaller residual after which a step ends."""
_SMALLER = 0.98
"""Factor by which a residual counts as smaller."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Simulated(FirstOrderLaw):
    """Learning on a simulated plant between two runs of the real one, for plants far from linear.

    A linear T_u misleads where friction holds a motor: its gain changes tenfold within one record.
    Here the law learns on a simulated plant, whose error is brought to that of the real one by what
    the last run left unexplained:

        d_k     = Q_d(e_k - e_m(u_k))
        u_{k+1} = the best of v_0 = u_k, v_{j+1} = law(v_j, e_m(v_j) + d_k)

    with e_m(v) the simulated error. The fixed point is that of e_k = 0 within the band of Q_d,
    however wrong the simulation is; how wrong it is decides how fast, and whether, learning gets
    there.
    """

    simulation: Callable[[Array], Array] = field(repr=False)
    """Error (N, n) of the simulated plant after a correction (N, n)."""
    law: FirstOrderLaw
    """Law of the passes on the simulated plant."""
    Q_d: RecordFilter = ALL_PASS
    """Filter of what the simulation leaves unexplained."""
    weight: tuple[float, ...]
    """(n,), weights of the columns in the size of a residual: the largest magnitude."""
    by_rms: bool = False
    """The size of a residual is its RMS: the largest value, in a corner, may grow at first."""
    passes: int = 12
    """Most passes on the simulated plant before each run."""

    def __post_init__(self) -> None:
        if self.passes < 1:
            raise ValueError(f"passes must be >= 1, got {self.passes}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.weight) != n_columns:
            raise ValueError(f"weight must have {n_columns} values, got {len(self.weight)}")
        self.law.check(n_samples, n_columns)
        self.Q_d.check(n_samples, n_columns)

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        simulated = self.simulation(correction)
        unexplained = self.Q_d(error - simulated)
        best, smallest, fruitless = correction, np.inf, 0
        for left in reversed(range(self.passes + 1)):
            residual = simulated + unexplained
            each = np.abs(residual * np.array(self.weight))
            size = float(np.sqrt((each**2).mean()) if self.by_rms else each.max())
            fruitless = 0 if size < _SMALLER * smallest else fruitless + 1
            if size < smallest:
                best, smallest = correction, size
            if not left or fruitless >= _FRUITLESS:
                break
            correction = self.law(correction, residual)
            simulated = self.simulation(correction)
        return best


@dataclass(frozen=True, kw_only=True, eq=False)
class JointSpace(FirstOrderLaw):
    """u_{k+1} = law(u_k, J^-1 e_k), e_k an error of the tool."""

    law: FirstOrderLaw
    inverse: Array
    """(n, p), inverse of the tool's Jacobian."""

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n := len(self.inverse)) != n_columns:
            raise ValueError(f"the inverse has {n} motors, the record {n_columns} columns")
        self.law.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        return self.law(correction, error @ self.inverse.T)
