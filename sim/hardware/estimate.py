"""Numbers that a robot file does not give, by rules from those that it gives."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

PER_CUBE = 40.0
"""[kg/m^3], mass of a robot over its stretched length cubed: industrial arms have 38 to 67, arms
for work beside people 8 to 14. ESTIMATE."""
BASE = 0.2
"""Fraction of a robot's mass in its base. ESTIMATE."""
LEAST = 0.05
"""Length that each link weighs at least, over the stretched length. ESTIMATE."""
TOOL = 0.02
"""Mass of the tool over that of the robot. ESTIMATE."""
DIGITS = 4
"""Digits of an estimated number: the same model on every machine."""


@dataclass(frozen=True)
class Taken:
    """A number that the file does not give."""

    field: str
    values: tuple[float, ...]
    rule: str

    def __str__(self) -> str:
        shown = ", ".join(f"{value:.4g}" for value in self.values)
        return f"{self.field} = {shown}: {self.rule}"


@dataclass
class Report:
    """Estimates in the order in which they are made."""

    taken: list[Taken] = field(default_factory=list)

    def take(
        self, name: str, values: Sequence[float] | Array, rule: str, *, exact: bool = False
    ) -> Array:
        """Note estimated numbers, and return them, rounded unless they are exact."""
        given = np.asarray(values, dtype=np.float64)
        found = given if exact else rounded(given)
        self.taken.append(Taken(name, tuple(np.atleast_1d(found).tolist()), rule))
        return found


def rounded(values: Array) -> Array:
    """Numbers with `DIGITS` digits."""
    return np.array([float(f"{v:.{DIGITS}g}") for v in values.ravel()]).reshape(values.shape)
