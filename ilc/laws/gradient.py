"""Steepest descent on ||e||^2: L = step T_u^T, the adjoint of the model."""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex
from ..models.system_matrix import (
    AnyModel,
    adjoint,
    check_inputs,
    check_model,
    require_effect,
    require_time_invariant,
)
from ..records import records


@dataclass(frozen=True, kw_only=True, eq=False)
class Gradient:
    """L = step T_u^T on the finite record; converges for 0 < step < 2 / max |T_u|^2.

    Of a model along the record the maximum is the 2-norm of its lifted matrix.
    """

    T_u: AnyModel
    step: float = 0.0
    """0 chooses 1 / max |T_u|^2, for which no frequency of the error grows."""

    def __post_init__(self) -> None:
        check_model(self.T_u)
        top = 2.0 / require_effect(self.T_u) ** 2
        if self.step == 0.0:
            object.__setattr__(self, "step", 0.5 * top)
        elif not 0.0 < self.step < top:
            needed = f"above 0 and below 2/max|T_u|^2 = {top:.6g}"
            raise ValueError(f"step must be {needed}, got {self.step}")

    def check(self, n_samples: int, n_columns: int) -> None:
        check_inputs(self.T_u, n_columns)

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        return self.step * adjoint(self.T_u, signal)

    def response(self, omega: ArrayLike) -> Complex:
        T = require_time_invariant(self.T_u, "a response").response(omega)
        return self.step * (T if T.ndim == 1 else T.swapaxes(1, 2)).conj()
