"""A task of a track: what an entry is given, its limits, and runs that only the judge can judge."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array

from .seal import Round


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Corrections that a robot takes; it does not move with others."""

    correction: Array
    """(n,) largest size of each column [rad]."""
    change: Array
    """(n,) largest change from one sample to the next [rad], from zero before the first."""

    def exceeded(self, correction: Array) -> str:
        """What is beyond its limit, in words; empty for a correction (N, n) that is allowed."""
        change = np.abs(
            np.diff(correction, axis=0, prepend=np.zeros((1, correction.shape[1])))
        ).max(axis=0)
        for what, found, most in (
            ("correction", np.abs(correction).max(axis=0), self.correction),
            ("change in one sample", change, self.change),
        ):
            i = int(np.argmax(found / most))
            if found[i] > most[i]:
                return f"{what} of column {i + 1} is {found[i]:.3g} rad, at most {most[i]:.3g}"
        return ""


@dataclass(frozen=True, kw_only=True)
class Task:
    """One task; `given` is all that an entry sees before its first run."""

    given: dict[str, Any]
    limits: Limits
    run: Callable[[int, Array], tuple[dict[str, Any], float]]
    """Records and true error of run k with a correction (N, n)."""
    plain: Callable[[], Array]
    """(K,) true errors without correction: of each run, or one for all."""


Left = Callable[[Array, Array], float]
"""Part of the error that is left, from true errors (K,) with and without correction."""
Ranges = Mapping[str, tuple[tuple[float, float], tuple[float, float]]]
"""Of each quantity its range in development and in judged rounds."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """A kind of task, and how its runs are scored."""

    name: str
    runs: int
    """That an entry may make."""
    seconds: float
    """For each answer of an entry."""
    draw: Callable[[Round, int], Task]
    left: Left
    score: str
    """The score in words."""
    ranges: Ranges
    goes_on: bool = False
    """Runs go on with the last correction after an entry stops: the robot changes by itself."""


def last(errors: Array, plain: Array) -> float:
    """Of the last run."""
    return float(errors[-1] / plain[-1])


class Drawn:
    """Draws of a task from the ranges of its round."""

    def __init__(self, ranges: Ranges, round: Round, *words: object) -> None:
        self.ranges, self.judged, self.rng = ranges, round.judged, round.rng(*words)
        self._round, self._words = round, words

    def key(self, *words: object) -> int:
        """256 bits of the task's own: a seed that cannot be tried out."""
        return self._round.key(*self._words, *words)

    def __call__(self, name: str) -> float:
        """Uniform in the range of a quantity."""
        return float(self.rng.uniform(*self.ranges[name][self.judged]))

    def log(self, name: str) -> float:
        """The same, of its logarithm."""
        return float(np.exp(self.rng.uniform(*np.log(self.ranges[name][self.judged]))))
