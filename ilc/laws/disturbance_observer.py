"""Disturbance observer over the iterations: estimate, predict and cancel (thesis 7.6)."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..models.system_matrix import Model
from ..records import records
from .law import FilteredLaw


@dataclass(frozen=True, kw_only=True)
class DisturbanceObserver(FilteredLaw):
    """u_{k+1} = Q L d_hat_{k+1}, the disturbance predicted from all iterations so far.

    d_k = e_k + T_u u_k is the error without correction. It is modelled as an autoregressive
    process over the iterations whose `order` coefficients are the same at all times of the record
    and are fitted by least squares. Until there are enough iterations, d_k is the prediction.
    After the disturbance observer of Chen and Moore (2002).
    """

    T_u: Model
    order: int = 2
    """Order of the autoregressive model [iterations]."""
    ridge: float = 1e-6
    """Relative ridge regularisation of the fit: the smallest of equally good coefficients."""

    def __post_init__(self) -> None:
        if self.order < 1:
            raise ValueError(f"order must be >= 1, got {self.order}")
        if not self.ridge > 0.0:
            raise ValueError(f"ridge must be > 0, got {self.ridge}")

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: tuple[Array, ...] | None = None, /
    ) -> tuple[Array, tuple[Array, ...]]:
        observed = (*(memory or ()), error + self.T_u.simulate(correction))
        return self.Q(self.L(self._predict(observed))), observed

    def _predict(self, observed: tuple[Array, ...]) -> Array:
        """d_hat_{k+1} = sum_i c_i d_{k-i}."""
        if len(observed) <= self.order:
            return observed[-1]
        p = self.order
        normal, right = np.zeros((p, p)), np.zeros(p)
        for k in range(p, len(observed)):
            past = np.stack([observed[k - 1 - i].ravel() for i in range(p)])
            normal += past @ past.T
            right += past @ observed[k].ravel()
        rho = self.ridge * np.trace(normal) / p
        if rho == 0.0:
            return observed[-1]
        c = np.linalg.solve(normal + rho * np.eye(p), right)
        return sum((ci * observed[-1 - i] for i, ci in enumerate(c)), np.zeros_like(observed[-1]))
