"""A law without design variables: gain, shift and cutoff follow from the data of its first runs.

The first update adds half of the error, filtered. Every further one identifies the impulse response
of the plant from the changes of all runs, with its covariance S, and minimises the expected error

    E ||e - G d||^2 = ||e - G d||^2 + d^T E[dG^T dG] d

Where the response is not known the second term keeps d small, so the band grows as runs tell more.
No response explains a motor that friction holds. With the reference known, the friction of each
motor is identified as well: the correction that its motion needed is taken out of the changes, and
what the reference needs beyond the best run's motion is added to d.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..filters import RecordFilter
from ..identification.friction import friction
from ..identification.impulse_response import (
    ImpulseEstimate,
    Sums,
    correlation_time,
    impulse_response,
)
from ..records import as_record, records

FIRST = 0.5
"""Part of the error that the first update adds, and of a step of which nothing is explained."""


class Known(NamedTuple):
    """Memory: all K runs so far."""

    corrections: Array
    """(K, N, m)."""
    errors: Array
    """(K, N, m)."""

    @property
    def best(self) -> int:
        """Run of the smallest error."""
        return int(np.argmin(np.linalg.norm(self.errors, axis=(1, 2))))


@dataclass(frozen=True, kw_only=True, eq=False)
class KnobFree:
    """Expected-error minimising law with an identified plant. Nothing has to be chosen.

    Assumed: the correction acts as the reference of a servo does, T_u with a gain of about 1 and a
    delay over which the error's autocorrelation rho stays above 1/4. Then ||e_1|| < ||e_0||, since
    ||e - u||^2 is (1 + 1/4 - rho(d)) ||e||^2 with u = e/2 delayed by d. Every update starts from
    the best run; after each that brought no better one it is half as long. Motors share one
    response, of servos of one kind. The step of each motor lies between half and whole, by the part
    of its changes that response and friction explain. Where the plant is not so, early runs may be
    worse than run 0, and the response found from them mends that.
    """

    Q: RecordFilter
    """Of the first update and each change: a low-pass below the noise, such as a tenth of the
    sample rate."""
    n_taps: int = 60
    """Samples of the impulse response."""
    reference: Array | None = None
    """r (N, m), for e = r - y: the friction of the motors is identified. None: it is not."""

    def __post_init__(self) -> None:
        if self.n_taps < 2:
            raise ValueError(f"n_taps must be >= 2, got {self.n_taps}")
        if self.reference is not None:
            object.__setattr__(self, "reference", as_record(self.reference, "reference"))

    def check(self, n_samples: int, n_columns: int) -> None:
        self.Q.check(n_samples, n_columns)
        if self.reference is not None and self.reference.shape != (n_samples, n_columns):
            needed = f"reference has shape {self.reference.shape}"
            raise ValueError(f"{needed}, the record has {(n_samples, n_columns)}")

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: Known | None = None, /
    ) -> tuple[Array, Known]:
        if memory is None:
            memory = Known(correction[None], error[None])
            return correction + FIRST * self.Q(error), memory
        given = (memory.corrections, correction), (memory.errors, error)
        memory = Known(*(np.concatenate((all_, one[None])) for all_, one in given))
        best, setbacks = memory.best, len(memory.errors) - 1 - memory.best
        change, seen = np.diff(memory.corrections, axis=0), -np.diff(memory.errors, axis=0)
        held, missing = self._held(memory)
        acting = change - held
        sums = _of_changes(change, acting, seen, self.n_taps)
        if not (sums.normal.any() and sums.power > 0.0):
            return memory.corrections[best], memory
        found = impulse_response(sums)
        left = seen[-1] - found.simulate(acting[-1])
        step = expected_best(found, correlation_time(left), memory.errors[best])
        known = _explained(seen, [found.simulate(v) for v in acting])
        step = self.Q(step + missing) * (FIRST + (1.0 - FIRST) * known)
        return memory.corrections[best] + 0.5**setbacks * step, memory

    def _held(self, memory: Known) -> tuple[Array, Array]:
        """Change of friction from run to run (K - 1, N, m), and from the best to the reference."""
        if self.reference is None:
            return np.zeros_like(memory.errors[1:]), np.zeros_like(memory.errors[0])
        errors = [self.Q(e) for e in memory.errors]
        corrections = [self.Q(u) for u in memory.corrections]
        model = friction(self.reference, list(zip(corrections, errors, strict=True)))
        needed = np.stack([model.as_correction(self.reference - e) for e in errors])
        return np.diff(needed, axis=0), model.as_correction(self.reference) - needed[memory.best]


def _explained(seen: Array, simulated: list[Array]) -> Array:
    """(m,): fraction of all changes (K, N, m) of each column that the model explains."""
    power = np.square(seen).sum(axis=(0, 1))
    power[power == 0.0] = np.inf
    return np.maximum(1.0 - np.square(seen - np.stack(simulated)).sum(axis=(0, 1)) / power, 0.0)


def _of_changes(change: Array, acting: Array, seen: Array, n_taps: int) -> Sums:
    """Sums of what acted and what was seen, (K, N, m), over the norm of their change: each motor
    says as much as any other."""
    sums = Sums.none(n_taps)
    for du, v, y in zip(change, acting, seen, strict=True):
        size = np.linalg.norm(du, axis=0)
        moved = size > 0.0
        if moved.any():
            sums = sums.with_records(v[:, moved] / size[moved], y[:, moved] / size[moved])
    return sums


@records("error")
def expected_best(found: ImpulseEstimate, certainty: float, error: Array) -> Array:
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
