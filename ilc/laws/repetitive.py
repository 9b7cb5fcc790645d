"""Repetitive control: laps of one period within a run, each corrected by what the last one left.

    u(t) = Q (u(t - N) + L e(t - N))

A delay line of one period with Q in its loop is a model of every periodic signal (internal model
principle). Hara, Yamamoto, Omata and Nakano, "Repetitive control system: a new type servo system
for periodic exogenous signals" (1988); Longman, "Iterative learning control and repetitive control
for engineering practice" (2000). Stable where |Q (1 - L T_u)| < 1 at all frequencies.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from ..records import as_whole, records
from .first_order import FirstOrderLaw


@dataclass(frozen=True, kw_only=True)
class Repetitive(FirstOrderLaw):
    """Law for records of repeated laps, learned from one run to the next.

    The correction of the laps is periodic: the laps after the first are averaged, which leaves less
    noise, and their errors are filtered around the lap, which has no ends.
    """

    L: RecordFilter
    Q: RecordFilter = ALL_PASS
    period: int
    """Samples of a lap."""
    begin: int = 0
    """First sample of the first lap; before it the correction fades in."""

    def __post_init__(self) -> None:
        for name in ("period", "begin"):
            object.__setattr__(self, name, int(as_whole(getattr(self, name), name)))
        if self.period < 2 or self.begin < 0:
            given = f"got {self.period} and {self.begin}"
            raise ValueError(f"period and begin must be >= 2 and >= 0, {given}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if n_samples < self.begin + 2 * self.period:
            needed = f"{self.begin} samples and two laps of {self.period}"
            raise ValueError(f"the record must hold {needed}, got {n_samples}")
        lap = np.zeros((self.period, n_columns))
        try:
            around(self.Q, around(self.L, lap))
        except ValueError as error:
            short = f"a lap of {self.period} samples is too short for its filters"
            raise ValueError(f"{short}: {error}") from error

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        lap = self.lap(correction) + around(self.L, self.lap(error))
        return self.laps(around(self.Q, lap), len(correction))

    @records("signal")
    def lap(self, signal: Array) -> Array:
        """Mean lap (period, n) of a record, without the first, in which the plant settles."""
        after = signal[self.begin + self.period :]
        whole = len(after) // self.period
        return after[: whole * self.period].reshape(whole, self.period, -1).mean(axis=0)

    @records("lap")
    def laps(self, lap: Array, n_samples: int) -> Array:
        """(N, n): the lap repeated, faded in before the first."""
        at = np.arange(n_samples) - self.begin
        fade = np.minimum(1.0, (np.arange(n_samples) + 1.0) / (self.begin + 1.0))
        return lap[at % self.period] * fade[:, None]


@records("lap")
def around(F: RecordFilter, lap: Array) -> Array:
    """Filter a lap (n_samples, n) that repeats: three laps are filtered, the middle one kept."""
    n = len(lap)
    return F(np.concatenate((lap, lap, lap)))[n : 2 * n]
