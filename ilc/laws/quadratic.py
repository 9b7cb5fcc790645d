"""Quadratic criterion of norm-optimal learning on a finite record, and its solution.

The step d = u_{k+1} - u_k solves H d = g with H = T' F' We F T + Wu + Wd and the negative gradient
g = T' F' We F e_k - Wu u_k at u_k. A Riccati recursion factors H in O(N) for models with states;
conjugate gradients with the model itself check and refine each solution, and solve for the others.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import recursion
from ..models.products import require_adjoint
from ..models.state_space import StateSpace, TimeVarying
from ..models.system import System
from ..models.system_matrix import AnyModel, SystemMatrix, check_inputs, n_outputs_of
from ..records import as_real

if TYPE_CHECKING:
    from .riccati import Factored

Apply = Callable[[Array], Array]

ACCURACY = 1e-7
"""Largest error of a solution relative to its size; one that does not reach it is an error."""
_REFINED = 1e-11  # error at which refinement ends
_FACTORED, _MATRIX_FREE = 30, 3000  # largest numbers of steps


def conjugate_gradients(
    A: Apply, precondition: Apply, b: Array
) -> Iterator[tuple[Array, Array, float]]:
    """x of A x = b after each step from 0, z = precondition(r) of the residual r, and r^T z."""
    x, r = np.zeros_like(b), b
    z = p = precondition(r)
    size = float(np.vdot(r, z))
    while size != 0.0:
        Ap = A(p)
        along = size / float(np.vdot(p, Ap))
        x, r = x + along * p, r - along * Ap
        z = precondition(r)
        before, size = size, float(np.vdot(r, z))
        yield x, z, size
        p = z + size / before * p


def solve_factored(hessian: Apply, precondition: Apply, g: Array) -> tuple[Array, float]:
    """(d, error): H d = g by a preconditioner that is nearly the inverse of H.

    error: estimate of |d - H^-1 g| / |d|, the size of one more correction.
    """
    d, estimate, last = np.zeros_like(g), 0.0, np.inf
    for d, z, size in islice(conjugate_gradients(hessian, precondition, g), _FACTORED):
        estimate = float(np.linalg.norm(z) / np.linalg.norm(d))
        if estimate <= _REFINED or not size > 0.0 or estimate > 0.5 * last:
            break
        last = estimate
    return d, estimate


def solve_matrix_free(hessian: Apply, R: Array, g: Array) -> tuple[Array, float]:
    """(d, error): H d = g for H >= diag(R) > 0, of which only products are known.

    error: bound of |d - H^-1 g| / |d| in the norm of R, for r^T H^-1 r <= r^T R^-1 r.
    """
    d, estimate = np.zeros_like(g), 0.0
    for d, _, size in islice(conjugate_gradients(hessian, lambda r: r / R, g), _MATRIX_FREE):
        estimate = float(np.sqrt(size / np.vdot(d, R * d)))
        if estimate <= 0.01 * ACCURACY or not size > 0.0:
            break
    if not d.any():
        return d, estimate
    r = g - hessian(d)  # of the solution itself: the updated one drifts by rounding
    return d, max(estimate, float(np.sqrt(np.vdot(r, r / R) / np.vdot(d, R * d))))


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
            weight = as_real(getattr(self, name), f"the weight of the {name}")
            if not np.isfinite(weight).all() or (weight < 0.0).any():
                raise ValueError(f"the weight of the {name} must be >= 0 and finite")
        if not (np.any(self.correction) or np.any(self.change)):
            raise ValueError("the weights of correction and change must not both be 0")
        taps = np.atleast_1d(as_real(self.error_filter, "error_filter"))
        if taps.ndim != 1 or not np.isfinite(taps).all() or not taps.any():
            raise ValueError(f"error_filter must be finite coefficients, not all 0, got {taps}")
        object.__setattr__(self, "error_filter", taps)


@dataclass(frozen=True, eq=False)
class QuadraticProblem:
    """Criterion for one model and records of one length N, p outputs and m inputs."""

    T_u: AnyModel
    taps: Array
    """Coefficients of F."""
    We: Array
    """(N, p), of each sample and output; Wu and Wd (N, m), of each input."""
    Wu: Array
    Wd: Array

    @classmethod
    def build(
        cls, T_u: AnyModel, criterion: QuadraticCriterion, n_samples: int, n_columns: int
    ) -> "QuadraticProblem":
        """Problem for corrections (N, n_columns). ValueError for weights of another shape."""
        check_inputs(T_u, n_columns)
        if (covered := getattr(T_u, "n_samples", n_samples)) != n_samples:
            raise ValueError(f"T_u covers {covered} samples, the record {n_samples}")
        p, m = n_outputs_of(T_u, n_columns), n_columns
        expanded = (
            per_sample(getattr(criterion, name), n_samples, width, f"the weight of the {name}")
            for name, width in (("error", p), ("correction", m), ("change", m))
        )
        problem = cls(T_u, np.asarray(criterion.error_filter), *expanded)
        _ = problem.parts  # refuses a criterion that does not determine the correction
        return problem

    @cached_property
    def parts(self) -> "list[tuple[list[int], Factored]]":
        """Inputs that are coupled, and the factored criterion of these; none without states."""
        T, R = self.T_u, self.Wu + self.Wd
        if not isinstance(T, System | SystemMatrix | StateSpace | TimeVarying):
            if not (R > 0.0).all():
                raise ValueError(
                    "a model without states needs weights of correction and change whose sum is > 0"
                )
            require_adjoint(T, len(R))
            return []
        from ..models.conversion import realise
        from .riccati import factor  # imported here: compiled

        n = R.shape[1]
        if isinstance(T, StateSpace | TimeVarying):
            return [(list(range(n)), factor(T.filtered_realisation(self.taps), self.We, R))]
        T = SystemMatrix.diagonal([T] * n) if isinstance(T, System) else T
        parts, known = [], {}
        for columns in T.coupled_columns():
            one = T.submatrix(columns)
            W, weights = self.We[:, columns], R[:, columns]
            key = (tuple(map(id, one.entries[0])), W.tobytes(), weights.tobytes())
            if key not in known or len(columns) > 1:
                known[key] = factor(realise(one, self.taps, len(W)), W, weights)
            parts.append((columns, known[key]))
        return parts

    def filtered(self, error: Array) -> Array:
        """F e."""
        return recursion(self.taps, np.ones(1), error)

    def weighted_back(self, filtered: Array) -> Array:
        """T' F' We times a filtered error."""
        return self.T_u.adjoint(self.filtered((self.We * filtered)[::-1])[::-1])

    def descent(self, correction: Array, error: Array) -> Array:
        """g: negative gradient of half the criterion at u_k, where the error is e_k."""
        return self.weighted_back(self.filtered(error)) - self.Wu * correction

    def hessian(self, step: Array) -> Array:
        """H d."""
        effect = self.weighted_back(self.filtered(self.T_u.simulate(step)))
        return effect + (self.Wu + self.Wd) * step

    def solve(self, g: Array) -> Array:
        """d with H d = g. Raises RuntimeError where rounding keeps it from `ACCURACY`."""
        if self.parts:
            d, error = solve_factored(self.hessian, self._by_parts, g)
            remedy = "give the model fewer slow poles, or raise the weight of the change"
        else:
            d, error = solve_matrix_free(self.hessian, self.Wu + self.Wd, g)
            remedy = "raise the weight of the change, or give the model in states"
        if not error <= ACCURACY:
            raise RuntimeError(
                f"the norm-optimal step is known to {error:.1g} of its size only, not "
                f"{ACCURACY:g}: {remedy}"
            )
        return d

    def _by_parts(self, r: Array) -> Array:
        z = np.empty_like(r)
        for columns, factored in self.parts:
            z[:, columns] = factored.solve(r[:, columns])
        return z


def per_sample(weight: Weight, n_samples: int, n_columns: int, name: str) -> Array:
    """Weight of each sample and column, (N, n); `name` is used in messages."""
    values = as_real(weight, name)
    values = values[:, None] if values.ndim == 1 else values
    try:
        return np.broadcast_to(values, (n_samples, n_columns))
    except ValueError:
        raise ValueError(
            f"{name} must be a number, ({n_samples},) or ({n_samples}, {n_columns}), "
            f"got {np.shape(weight)}"
        ) from None
