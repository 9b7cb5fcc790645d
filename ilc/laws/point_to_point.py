"""Point-to-point learning: the output has to be right at some samples and is free between them.

Norm-optimal learning whose error has no weight elsewhere; what is free lets the correction stay
small. Freeman, "Constrained point-to-point iterative learning control with experimental
verification" (2012); Janssens, Pipeleers and Swevers, "A data-driven constrained norm-optimal
iterative learning control framework for LTI systems" (2013).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from ..models.system_matrix import AnyModel
from ..records import as_whole, records
from .law import FirstOrderLaw
from .norm_optimal import NormOptimal
from .quadratic import QuadraticCriterion


@dataclass(frozen=True, kw_only=True, eq=False)
class PointToPoint(FirstOrderLaw):
    """Norm-optimal law for the error at given samples."""

    T_u: AnyModel
    points: Sequence[int]
    """Samples at which the output has to be right, in 0 .. N - 1."""
    n_samples: int
    n_columns: int = 1
    correction: float = 1e-6
    change: float = 1e-4
    """Weights of u and of its change, relative to that of the error."""

    def __post_init__(self) -> None:
        points = np.unique(as_whole(self.points, "each of the points"))
        if not len(points) or points[0] < 0 or points[-1] >= self.n_samples:
            raise ValueError(f"points must be samples 0 to {self.n_samples - 1}, got {self.points}")
        weight = np.zeros(self.n_samples)
        weight[points] = 1.0
        weights = QuadraticCriterion(error=weight, correction=self.correction, change=self.change)
        law = NormOptimal(
            T_u=self.T_u, n_samples=self.n_samples, n_columns=self.n_columns, criterion=weights
        )
        object.__setattr__(self, "_law", law)

    _law: NormOptimal = field(init=False, repr=False)

    def check(self, n_samples: int, n_columns: int) -> None:
        self._law.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        return self._law(correction, error)
