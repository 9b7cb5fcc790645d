"""A law that learns a change of a correction that is there already, such as a model's.

    u_{k+1} = u_c + law(u_k - u_c, e_k)

A filter Q of the law then takes nothing from u_c.
"""

from dataclasses import dataclass, field
from typing import Any

from armside.arrays import Array

from ..records import records
from .law import Law


@dataclass(frozen=True, eq=False)
class Around:
    """Law around a correction (N, n)."""

    law: Law
    centre: Array = field(repr=False)

    def check(self, n_samples: int, n_columns: int) -> None:
        if self.centre.shape != (n_samples, n_columns):
            needed = f"the shape {(n_samples, n_columns)} of the record"
            raise ValueError(f"centre must have {needed}, got {self.centre.shape}")
        self.law.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def step(self, correction: Array, error: Array, memory: Any = None, /) -> tuple[Array, Any]:
        change, memory = self.law.step(correction - self.centre, error, memory)
        return self.centre + change, memory
