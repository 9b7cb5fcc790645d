"""Schedule of laws: Q and L that vary over the iterations."""

from dataclasses import dataclass

from armside.arrays import Array

from ..records import records
from .law import FirstOrderLaw


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
