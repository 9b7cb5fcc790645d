"""An unknown pattern over the iterations, observed, predicted and cancelled (thesis 7.6)."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from ..models.system_matrix import Model


@dataclass(frozen=True, kw_only=True)
class DisturbanceObserver:
    """u_{k+1} = Q L d_hat_{k+1}, the disturbance predicted from what was observed so far.

    d_k = e_k + T_u u_k is the error there would have been without correction. It is taken for
    the output of a linear filter over the iterations; that filter's `order` coefficients are
    the same at all times of the record and are fitted by least squares over all iterations.
    Until there are enough iterations to fit, the newest disturbance is expected again.
    After the disturbance observer of Chen and Moore (2002).
    """

    T_u: Model
    L: RecordFilter
    """An inverse of T_u, such as `ModelInverse`."""
    order: int = 2
    """Iterations that the prediction looks back."""
    Q: RecordFilter = ALL_PASS
    ridge: float = 1e-6
    """Of the fit, relative: chooses the smallest coefficients when several patterns fit."""

    def __post_init__(self) -> None:
        if self.order < 1:
            raise ValueError(f"order must be >= 1, got {self.order}")
        if not self.ridge > 0.0:
            raise ValueError(f"ridge must be > 0, got {self.ridge}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.L.check(n_samples, n_columns)
        self.Q.check(n_samples, n_columns)

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
