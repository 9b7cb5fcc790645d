"""Evidence: a number and its band, tables of results, checks over many seeds, mean intervals."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..notes import Note


@dataclass(frozen=True)
class Check:
    """One number beside that of the thesis, and the band it should lie in, ends included."""

    id: str
    statement: str
    """The measured quantity, so that a reader knows the meaning of the number."""
    thesis: str
    """The number in the thesis; words where it gives none."""
    ours: float
    low: float | None = None
    high: float | None = None
    reason: str = ""
    """Cause of a failure, where it is known; shown only if the check fails."""

    def __post_init__(self) -> None:
        if self.low is None and self.high is None:
            raise ValueError(f"check {self.id} needs a band: low, high or both")
        object.__setattr__(self, "ours", float(self.ours))

    @property
    def holds(self) -> bool:
        """Inside the band. A value that is not finite never is."""
        low = -np.inf if self.low is None else self.low
        high = np.inf if self.high is None else self.high
        return bool(np.isfinite(self.ours) and low <= self.ours <= high)

    @property
    def verdict(self) -> str:
        """The verdict in one word."""
        return "holds" if self.holds else "FAILS"

    @property
    def band(self) -> str:
        """The band in words."""
        if self.low is None:
            return f"≤ {self.high:g}"
        if self.high is None:
            return f"≥ {self.low:g}"
        return f"{self.low:g} to {self.high:g}"


def all_hold(statement: str, cases: ArrayLike) -> Check:
    """The check that a statement holds in every case; its number is that of the exceptions."""
    exceptions = np.size(cases) - np.count_nonzero(cases)
    return Check("", statement, "", float(exceptions), high=0.0)


@dataclass(frozen=True)
class Table:
    """Rows of results, and the checks that follow from all of them."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]
    verdicts: Sequence[Check] = ()
    notes: Sequence[Note] = ()
    """Limits that changed the runs behind the rows."""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"a row has {len(row)} cells for {len(self.columns)} columns")

    def value(self, column: str, *beginning: Any) -> float:
        """The number in a column of the row that begins with these cells. Raises KeyError."""
        for row in self.rows:
            if tuple(row[: len(beginning)]) == beginning:
                return float(row[self.columns.index(column)])
        raise KeyError(f"no row of {self.title!r} begins with {beginning}")


def held(by_seed: Mapping[int, Sequence[Check]], fraction: float = 1.0) -> list[Check]:
    """Checks that each check holds for at least a fraction of the seeds, all in the same order."""
    n = len(by_seed)
    rule = "every seed" if fraction == 1.0 else f"at least {100 * fraction:.0f} % of the seeds"
    found = []
    for first, *others in zip(*by_seed.values(), strict=True):
        holding = sum(check.holds for check in (first, *others))
        words = f"{first.id}: {first.statement}: {first.band}, for {rule} ({holding} of {n})"
        found.append(Check(first.id, words, first.thesis, holding, low=math.ceil(fraction * n)))
    return found


def over_seeds(title: str, by_seed: Mapping[int, Sequence[Check]], fraction: float = 1.0) -> Table:
    """A row for each check, a column for each seed."""
    verdicts = held(by_seed, fraction)
    rows = []
    for checks, verdict in zip(zip(*by_seed.values(), strict=True), verdicts, strict=True):
        one, n = checks[0], f"{verdict.ours:.0f} of {len(checks)}"
        rows.append((one.id, one.statement, one.thesis, one.band, *(c.ours for c in checks), n))
    seeds = [f"seed {seed}" for seed in by_seed]
    return Table(title, ("", "what", "thesis", "band", *seeds, "holds"), rows, verdicts)


def mean_interval(values: Array, confidence: float = 0.95) -> tuple[float, float]:
    """Interval by Student's t of the mean of values (n,); infinite for one value."""
    from scipy.special import stdtrit

    n, mean = len(values), float(np.mean(values))
    if n < 2:
        return -np.inf, np.inf
    half = stdtrit(n - 1, 0.5 + 0.5 * confidence) * np.std(values, ddof=1) / np.sqrt(n)
    return mean - float(half), mean + float(half)
