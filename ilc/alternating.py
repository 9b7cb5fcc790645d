"""A task that is not the same every time: several plants, one after the other."""

from collections.abc import Sequence
from itertools import cycle
from typing import Generic, TypeVar

from .plant import Array, Plant

Result = TypeVar("Result")


class Alternating(Generic[Result]):
    """Runs the first plant at k = 0, the second at k = 1, ..., then the first again.

    Such as a robot that carries a part out and comes back empty (thesis 7.6).
    """

    def __init__(self, plants: Sequence[Plant[Result]]) -> None:
        if not plants:
            raise ValueError("plants must hold at least one plant")
        self._turn = cycle(plants)

    def run(self, correction: Array, /) -> Result:
        return next(self._turn).run(correction)
