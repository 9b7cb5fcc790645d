"""Evidence: a number and its band, and tables of results."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

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
