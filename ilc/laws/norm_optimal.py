"""Algorithm 3: norm-optimal learning, a quadratic criterion over the finite record."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex, System, require_stable
from ..models.system_matrix import Model, SystemMatrix
from ..records import records
from .law import FirstOrderLaw
from .quadratic import QuadraticCriterion, QuadraticProblem


@dataclass(frozen=True, kw_only=True, eq=False)
class NormOptimal(FirstOrderLaw):
    """Minimum of a `QuadraticCriterion` in every iteration, O(N) in design and iteration.

    T_u: one system, used for each motor, or a matrix of systems for coupled motors. Equal to
    Q = (T'WT + Wu + Wd)^-1 (T'WT + Wd), L = (T'WT + Wd)^-1 T'W in the lifted form, without
    building T. Raises RuntimeError where rounding keeps a minimum from being found.
    """

    T_u: Model
    n_samples: int
    n_columns: int = 1
    criterion: QuadraticCriterion = field(
        default_factory=lambda: QuadraticCriterion(correction=1e-4, change=1e-2)
    )

    def __post_init__(self) -> None:
        require_stable(self.T_u, "T_u")
        problem = QuadraticProblem.build(self.T_u, self.criterion, self.n_samples, self.n_columns)
        object.__setattr__(self, "_problem", problem)

    _problem: QuadraticProblem = field(init=False, repr=False)

    def check(self, n_samples: int, n_columns: int) -> None:
        designed, given = (self.n_samples, self.n_columns), (n_samples, n_columns)
        if given != designed:
            raise ValueError(f"the law was designed for records of shape {designed}, got {given}")

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        return correction + self._problem.solve(self._problem.descent(correction, error))

    def responses(self, omega: ArrayLike) -> tuple[Complex, Complex]:
        """(Q, L) on infinite records, for one system and constant weights, (M,) each."""
        if isinstance(self.T_u, SystemMatrix):
            raise ValueError("responses need a T_u with one input and one output")
        We, Wu, Wd = (self.criterion.error, self.criterion.correction, self.criterion.change)
        if any(np.ndim(weight) for weight in (We, Wu, Wd)):
            raise ValueError("responses need weights that do not vary over time")
        T = self.T_u.response(omega)
        taps = np.asarray(self.criterion.error_filter)
        F = System(taps, np.ones(1), self.T_u.sample_time).response(omega)
        power = np.square(np.abs(F)) * We
        known = np.square(np.abs(T)) * power + Wd
        return (known / (known + Wu)).astype(complex), T.conj() * power / known
