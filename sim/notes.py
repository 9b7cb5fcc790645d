"""Notes of a run: limits and faults that changed what was asked."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum

GROWTH = 1.05
"""Error of the tool over that at k = 0 from which on it is noted: above the tracker's noise."""


class Cause(Enum):
    """Cause of a note."""

    SPEED = "speed"
    """The programmed speed was lowered."""
    ACCELERATION = "acceleration"
    """An acceleration limit made a motion longer."""
    SATURATION = "saturation"
    """A drive or a joint reached its limit."""
    DRAWING = "drawing"
    """Something of a drawing is not cut."""
    BEAM = "beam"
    """The laser tracker lost the reflector."""
    GUARD = "guard"
    """Learning went back to its best iteration."""
    IMU = "imu"
    """Samples of the IMU were bridged, or not used at all."""
    TWIN = "twin"
    """A digital twin was not trusted, or has to be commissioned again."""
    PROGRAM = "program"
    """A program was written without its correction."""
    SCAN = "scan"
    """Something of a scan was not used, or had to be assumed."""
    FORECAST = "forecast"
    """Learning is forecast to make the tool worse."""
    TOOL = "tool"
    """The tool got worse although the learned output did not."""


@dataclass(frozen=True, kw_only=True)
class Note:
    """A limit or fault that changed what was asked, in one line."""

    cause: Cause
    text: str
    runs: tuple[int, ...] = ()
    """Runs that it concerns, such as iterations; empty for all of them."""

    def at(self, run: int) -> "Note":
        """The note of one run."""
        return replace(self, runs=(run,))

    @property
    def line(self) -> str:
        """The text with its runs."""
        if not self.runs:
            return self.text
        return f"{self.text} (k = {_ranges(self.runs)})"


def together(notes: Iterable[Note]) -> list[Note]:
    """One note for each cause and text, with the runs of all."""
    runs: dict[Note, list[int]] = {}
    for note in notes:
        runs.setdefault(replace(note, runs=()), []).extend(note.runs)
    return [replace(note, runs=tuple(sorted(set(of)))) for note, of in runs.items()]


def counted(notes: Iterable[Iterable[Note]], what: str) -> list[Note]:
    """Notes of many runs: one for each cause, its first text with the number of runs.

    notes: of each run. what: the runs, such as "episodes".
    """
    tally = Tally()
    for of_run in notes:
        tally.add(of_run)
    return tally.notes(what)


class Tally:
    """Notes of many runs, counted as the runs are made."""

    def __init__(self) -> None:
        self._runs = 0
        self._n: Counter[Cause] = Counter()
        self._first: dict[Cause, Note] = {}

    def add(self, notes: Iterable[Note]) -> None:
        """Count the notes of one more run."""
        of_run = list(notes)
        self._runs += 1
        self._n.update({note.cause for note in of_run})
        for note in of_run:
            self._first.setdefault(note.cause, note)

    def include(self, other: "Tally") -> None:
        """Count the runs of another tally too."""
        self._runs += other._runs
        self._n.update(other._n)
        for cause, note in other._first.items():
            self._first.setdefault(cause, note)

    def notes(self, what: str) -> list[Note]:
        """One note for each cause, its first text with the number of runs."""
        return [
            replace(note, text=f"{note.text} (in {self._n[cause]} of {self._runs} {what})", runs=())
            for cause, note in self._first.items()
        ]


def _ranges(runs: tuple[int, ...]) -> str:
    """Such as "0 to 3, 5"."""
    parts: list[list[int]] = []
    for k in runs:
        if parts and k == parts[-1][-1] + 1:
            parts[-1].append(k)
        else:
            parts.append([k])
    return ", ".join(f"{p[0]} to {p[-1]}" if len(p) > 1 else f"{p[0]}" for p in parts)
