"""A law without design variables: gain, shift and cutoff follow from the data of its first runs.

The first update adds half of the error, filtered. Every further one identifies the impulse response
of the plant from the changes of all runs, with its covariance S, and minimises the expected error

    E ||e - G d||^2 = ||e - G d||^2 + d^T E[dG^T dG] d

Where the response is not known the second term keeps d small, so the band grows as runs tell more.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..filters import RecordFilter
from ..identification.impulse_response import (
    ImpulseResponse,
    Sums,
    correlation_time,
    impulse_response,
)
from ..records import records

FIRST = 0.5
"""Part of the error that the first update adds."""


class Known(NamedTuple):
    """Memory: sums of all changes so far, the last run and the best."""

    normal: Array
    right: Array
    power: float
    n_samples: int
    correction: Array
    error: Array
    best_correction: Array
    best_error: Array
    setbacks: int
    """Updates since the best run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class KnobFree:
    """Expected-error minimising law with an identified plant. Nothing has to be chosen.

    Assumed: the correction acts as the reference of a servo does, T_u with a gain of about 1 and a
    delay over which the error's autocorrelation rho stays above 1/4. Then ||e_1|| < ||e_0||, since
    ||e - u||^2 is (1 + 1/4 - rho(d)) ||e||^2 with u = e/2 delayed by d. Every update starts from
    the best run; after each that brought no better one it is half as long. Motors share one
    response, of servos of one kind; the second update of each is as long as the part of its change
    that this response explains. Where the plant is not so, early runs may be worse than run 0, and
    the response found from them mends that.
    """

    Q: RecordFilter
    """Of the first update and each change: a low-pass below the noise, such as a tenth of the
    sample rate."""
    n_taps: int = 60
    """Samples of the impulse response."""

    def __post_init__(self) -> None:
        if self.n_taps < 2:
            raise ValueError(f"n_taps must be >= 2, got {self.n_taps}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.Q.check(n_samples, n_columns)

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: Known | None = None, /
    ) -> tuple[Array, Known]:
        if memory is None:
            none = Sums.none(self.n_taps)
            memory = Known(*none, correction, error, correction, error, 0)
            return correction + FIRST * self.Q(error), memory
        change, seen = correction - memory.correction, memory.error - error
        sums = _with_change(Sums(*memory[:4]), change, seen)
        better = np.linalg.norm(error) < np.linalg.norm(memory.best_error)
        best = (correction, error) if better else (memory.best_correction, memory.best_error)
        setbacks = 0 if better else memory.setbacks + 1
        memory = Known(*sums, correction, error, *best, setbacks)
        if not (sums.normal.any() and sums.power > 0.0):
            return best[0], memory
        found = impulse_response(sums)
        left = seen - found.simulate(change)
        step = self.Q(expected_best(found, correlation_time(left), best[1]))
        if sums.n_samples <= error.size:  # the only run that tells of the response
            step = step * _explained(seen, left)
        return best[0] + 0.5**setbacks * step, memory


def _explained(seen: Array, left: Array) -> Array:
    """(m,): fraction of the last change of each column that the shared response explains."""
    power = np.square(seen).sum(axis=0)
    power[power == 0.0] = np.inf
    return np.maximum(1.0 - np.square(left).sum(axis=0) / power, 0.0)


def _with_change(sums: Sums, change: Array, seen: Array) -> Sums:
    """Columns over the norm of their change: each motor says as much as any other."""
    size = np.linalg.norm(change, axis=0)
    moved = size > 0.0
    if not moved.any():
        return sums
    return sums.with_records(change[:, moved] / size[moved], seen[:, moved] / size[moved])


@records("error")
def expected_best(found: ImpulseResponse, certainty: float, error: Array) -> Array:
    """d (N, m) that minimises E ||e - G d||^2, the covariance of G times `certainty`. O(N n^2)."""
    from scipy.linalg import solveh_banded

    n_samples, g = len(error), found.taps
    n = min(len(g), n_samples)
    second = np.outer(g, g) + certainty * found.covariance
    band = np.zeros((n, n_samples))  # upper form: row n - 1 - l is the l-th superdiagonal
    for lag in range(n):
        sums = np.cumsum(np.diagonal(second, lag)[: n - lag])
        left = n_samples - lag  # entries (i, i + lag); their sums end with the record
        terms = np.minimum(left - np.arange(left), len(sums)) - 1
        band[n - 1 - lag, lag:] = sums[terms]
    band[-1] += 1e-9 * band[-1].max()
    back = [np.convolve(column[::-1], g)[:n_samples][::-1] for column in error.T]
    return solveh_banded(band, np.stack(back, axis=1))
