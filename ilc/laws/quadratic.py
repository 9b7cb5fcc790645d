"""Quadratic criterion of norm-optimal learning on a finite record, and its solution.

The step d = u_{k+1} - u_k solves H d = g with H = T' F' We F T + Wu + Wd and the negative gradient
g = T' F' We F e_k - Wu u_k at u_k. A Riccati recursion factors H in O(N); conjugate gradients, with
the model itself for H and the recursion as preconditioner, check each solution and refine it.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import recursion
from ..models.system import System
from ..models.system_matrix import Model, SystemMatrix, adjoint, check_inputs

if TYPE_CHECKING:
    from .riccati import Factored

ACCURACY = 1e-7
"""Largest error of a step relative to its size; a solution that does not reach it is an error."""
_REFINED, _STEPS = 1e-11, 30  # error at which refinement ends, and its largest number of steps

Weight = float | Array
"""One number, or one for each sample (N,), or for each sample and column (N, n); >= 0."""


@dataclass(frozen=True, kw_only=True, eq=False)
class QuadraticCriterion:
    """J = ||F e_{k+1}||^2_We + ||u_{k+1}||^2_Wu + ||u_{k+1} - u_k||^2_Wd. Thesis Algorithm 3.

    Weights along the record weight the time, the filter F the frequencies. Wu > 0 trades an
    asymptotic error for robustness, as Q < 1 does; Wd only slows learning down.
    """

    error: Weight = 1.0
    correction: Weight = 0.0
    change: Weight = 0.0
    error_filter: ArrayLike = (1.0,)
    """Coefficients of F in powers of q^-1, finite impulse response."""

    def __post_init__(self) -> None:
        for name in ("error", "correction", "change"):
            weight = np.asarray(getattr(self, name), dtype=np.float64)
            if not np.isfinite(weight).all() or (weight < 0.0).any():
                raise ValueError(f"the weight of the {name} must be >= 0 and finite")
        if not (np.any(self.correction) or np.any(self.change)):
            raise ValueError("the weights of correction and change must not both be 0")
        taps = np.atleast_1d(np.asarray(self.error_filter, dtype=np.float64))
        if taps.ndim != 1 or not np.isfinite(taps).all() or not taps.any():
            raise ValueError(f"error_filter must be finite coefficients, not all 0, got {taps}")
        object.__setattr__(self, "error_filter", taps)


@dataclass(frozen=True, eq=False)
class QuadraticProblem:
    """Criterion for one model and records of one shape (N, n)."""

    T_u: Model
    taps: Array
    """Coefficients of F."""
    We: Array
    """Weights of each sample and column, (N, n); likewise Wu and Wd."""
    Wu: Array
    Wd: Array

    @classmethod
    def build(
        cls, T_u: Model, criterion: QuadraticCriterion, n_samples: int, n_columns: int
    ) -> "QuadraticProblem":
        """Problem for records of shape (N, n). ValueError for weights of another shape."""
        check_inputs(T_u, n_columns)
        weights = [(getattr(criterion, name), name) for name in ("error", "correction", "change")]
        expanded = (
            per_sample(weight, n_samples, n_columns, f"the weight of the {name}")
            for weight, name in weights
        )
        problem = cls(T_u, np.asarray(criterion.error_filter), *expanded)
        _ = problem.parts  # refuses a criterion that does not determine the correction
        return problem

    @cached_property
    def parts(self) -> "list[tuple[list[int], Factored]]":
        """Columns that are coupled, and the factored criterion of these."""
        from ..models.realisation import realise
        from .riccati import factor  # imported here: compiled

        n_samples, n = self.We.shape
        T = self.T_u if isinstance(self.T_u, SystemMatrix) else _repeated(self.T_u, n)
        parts, known = [], {}
        for columns in T.coupled_columns():
            one = T.submatrix(columns)
            W, R = self.We[:, columns], (self.Wu + self.Wd)[:, columns]
            key = (tuple(map(id, one.entries[0])), W.tobytes(), R.tobytes())
            if key not in known or len(columns) > 1:
                known[key] = factor(realise(one, self.taps, n_samples), W, R)
            parts.append((columns, known[key]))
        return parts

    def filtered(self, error: Array) -> Array:
        """F e."""
        return recursion(self.taps, np.ones(1), error)

    def weighted_back(self, filtered: Array) -> Array:
        """T' F' We times a filtered error."""
        return adjoint(self.T_u, self.filtered((self.We * filtered)[::-1])[::-1])

    def descent(self, correction: Array, error: Array) -> Array:
        """g: negative gradient of half the criterion at u_k, where the error is e_k."""
        return self.weighted_back(self.filtered(error)) - self.Wu * correction

    def hessian(self, step: Array) -> Array:
        """H d."""
        effect = self.weighted_back(self.filtered(self.T_u.simulate(step)))
        return effect + (self.Wu + self.Wd) * step

    def solve(self, g: Array) -> Array:
        """d with H d = g. Raises RuntimeError where rounding keeps it from `ACCURACY`."""
        d, r = np.zeros_like(g), g
        z = p = self._preconditioned(r)
        size, estimate = float(np.vdot(r, z)), np.inf
        if size == 0.0:
            return d
        for _ in range(_STEPS):
            Hp = self.hessian(p)
            along = size / float(np.vdot(p, Hp))
            d, r = d + along * p, r - along * Hp
            z = self._preconditioned(r)
            last, estimate = estimate, float(np.linalg.norm(z) / np.linalg.norm(d))
            size, before = float(np.vdot(r, z)), size
            if estimate <= _REFINED or not size > 0.0 or estimate > 0.5 * last:
                break
            p = z + size / before * p
        if not estimate <= ACCURACY:
            raise RuntimeError(
                f"the norm-optimal step is known to {estimate:.1g} of its size only, not "
                f"{ACCURACY:g}: give the model fewer slow poles, or raise the weight of the change"
            )
        return d

    def _preconditioned(self, r: Array) -> Array:
        z = np.empty_like(r)
        for columns, factored in self.parts:
            z[:, columns] = factored.solve(r[:, columns])
        return z


def _repeated(system: System, n: int) -> SystemMatrix:
    return SystemMatrix.diagonal([system] * n)


def per_sample(weight: Weight, n_samples: int, n_columns: int, name: str) -> Array:
    """Weight of each sample and column, (N, n); `name` is used in messages."""
    values = np.asarray(weight, dtype=np.float64)
    values = values[:, None] if values.ndim == 1 else values
    try:
        return np.broadcast_to(values, (n_samples, n_columns))
    except ValueError:
        raise ValueError(
            f"{name} must be a number, ({n_samples},) or ({n_samples}, {n_columns}), "
            f"got {np.shape(weight)}"
        ) from None
