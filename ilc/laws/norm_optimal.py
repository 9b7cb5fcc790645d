"""Algorithm 3: norm-optimal learning, a quadratic criterion over the finite record."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex, System
from ..models.system_matrix import AnyModel, check_model
from ..records import records
from .law import FirstOrderLaw
from .quadratic import QuadraticCriterion, QuadraticProblem


@dataclass(frozen=True, kw_only=True, eq=False)
class NormOptimal(FirstOrderLaw):
    """Minimum of a `QuadraticCriterion` in every iteration, O(N) in design and iteration.

    T_u: one system, used for each motor, or any other model: several inputs and outputs, varying
    along the record, or one's own `RecordModel`. Equal to Q = (T'WT + Wu + Wd)^-1 (T'WT + Wd),
    L = (T'WT + Wd)^-1 T'W in the lifted form, without building T. Raises RuntimeError where
    rounding keeps a minimum from being found.
    """

    T_u: AnyModel
    n_samples: int
    n_columns: int = 0
    """Columns of a correction; 0: the inputs of T_u."""
    criterion: QuadraticCriterion = field(
        default_factory=lambda: QuadraticCriterion(correction=1e-4, change=1e-2)
    )

    def __post_init__(self) -> None:
        check_model(self.T_u)
        if self.n_columns == 0:
            object.__setattr__(self, "n_columns", self.T_u.n_inputs)
        problem = QuadraticProblem.build(self.T_u, self.criterion, self.n_samples, self.n_columns)
        object.__setattr__(self, "_problem", problem)

    _problem: QuadraticProblem = field(init=False, repr=False)

    def check(self, n_samples: int, n_columns: int) -> None:
        designed, given = (self.n_samples, self.n_columns), (n_samples, n_columns)
        if given != designed:
            raise ValueError(f"the law was designed for records of shape {designed}, got {given}")

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        self._check_shapes(correction, error)
        return correction + self._problem.solve(self._problem.descent(correction, error))

    def _check_shapes(self, correction: Array, error: Array) -> None:
        for signal, weight, name in (
            (correction, self._problem.Wu, "correction"),
            (error, self._problem.We, "error"),
        ):
            if signal.shape != weight.shape:
                raise ValueError(f"{name} must have shape {weight.shape}, got {signal.shape}")

    def responses(self, omega: ArrayLike) -> tuple[Complex, Complex]:
        """(Q, L) on infinite records for constant weights: (M,) each for one system, (M, m, m) and
        (M, m, p) for several inputs and outputs."""
        response_of = getattr(self.T_u, "response", None)
        if response_of is None:
            raise ValueError("responses need a T_u with a frequency response")
        We, Wu, Wd = (self.criterion.error, self.criterion.correction, self.criterion.change)
        if any(np.ndim(weight) for weight in (We, Wu, Wd)):
            raise ValueError("responses need weights that do not vary over time")
        T: Complex = response_of(omega)
        taps = np.asarray(self.criterion.error_filter)
        F = System(taps, np.ones(1), 1.0).response(omega)
        power = np.square(np.abs(F)) * We
        if T.ndim == 1:
            known = np.square(np.abs(T)) * power + Wd
            return (known / (known + Wu)).astype(complex), T.conj() * power / known
        T_H, identity = T.conj().swapaxes(1, 2) * power[:, None, None], np.eye(T.shape[2])
        known = T_H @ T + Wd * identity
        Q, L = np.linalg.solve(known + Wu * identity, known), np.linalg.solve(known, T_H)
        return Q.astype(np.complex128), L.astype(np.complex128)
