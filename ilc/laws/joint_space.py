"""Motor law driven by the tool error through an inverse of the static Jacobian."""

from dataclasses import dataclass

from armside.arrays import Array

from ..records import records
from .law import FirstOrderLaw


@dataclass(frozen=True, kw_only=True, eq=False)
class JointSpace(FirstOrderLaw):
    """u_{k+1} = law(u_k, J^-1 e_k), e_k an error of the tool."""

    law: FirstOrderLaw
    inverse: Array
    """(n, p), inverse of the tool's Jacobian."""

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n := len(self.inverse)) != n_columns:
            raise ValueError(f"the inverse has {n} motors, the record {n_columns} columns")
        self.law.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        return self.law(correction, error @ self.inverse.T)
