"""Norm-optimal learning with bounds on the correction: one quadratic programme an iteration."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..records import as_real, records
from .norm_optimal import NormOptimal
from .quadratic import Weight, per_sample

_ROUNDS = 5  # of the solver, each from where the one before stopped


@dataclass(frozen=True, kw_only=True, eq=False)
class Constrained(NormOptimal):
    """Minimum of the criterion subject to |u| <= limit.

    The programme is convex with bounds only, so scipy's L-BFGS-B solves it; gradients are model
    runs forwards and backwards in time, O(N). Where no limit is active the result is that of
    `NormOptimal`.
    """

    limit: Weight = np.inf
    """Largest |u|: one number, (N,) or (N, n)."""
    tolerance: float = 1e-5
    """Largest projected gradient at the solution, relative to the gradient at u = 0. Rounding
    keeps models with many slow poles from much less than 1e-6."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (as_real(self.limit, "limit") > 0.0).all():
            raise ValueError("limit must be > 0")
        per_sample(self.limit, self.n_samples, self.n_columns, "limit")

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        free = super().__call__(correction, error)
        limit = per_sample(self.limit, self.n_samples, self.n_columns, "limit")
        if (np.abs(free) <= limit).all():
            return free
        return self._within(limit, free, correction, error)

    def _within(self, limit: Array, free: Array, correction: Array, error: Array) -> Array:
        problem = self._problem
        descent = problem.descent(correction, error)

        def gradient(u: Array) -> Array:
            return problem.hessian(u - correction) - descent

        u, scale = np.clip(free, -limit, limit), np.abs(gradient(np.zeros_like(free))).max()
        reached = np.inf
        for _ in range(_ROUNDS):
            u = self._minimum(limit, u, gradient(u), scale)
            reached = np.abs(np.clip(u - gradient(u), -limit, limit) - u).max() / scale
            if reached <= self.tolerance:
                return u
        raise RuntimeError(
            f"the quadratic programme stopped at a projected gradient of {reached:.2g}, not "
            f"{self.tolerance:.2g}"
        )

    def _minimum(self, limit: Array, start: Array, gradient: Array, scale: float) -> Array:
        """Minimum from a start with its gradient. The cost is counted from there: in that of all
        the record, rounding would hide the last descent."""
        from scipy.optimize import minimize

        def cost(flat: Array) -> tuple[float, Array]:
            step = flat.reshape(start.shape)
            turned = self._problem.hessian(step)
            return float(np.vdot(step, gradient + 0.5 * turned)), (gradient + turned).ravel()

        options = {"ftol": 0.0, "gtol": 0.1 * self.tolerance * scale, "maxcor": 30}
        options |= {"maxiter": 5000, "maxfun": 20000}
        bounds = np.column_stack(((-limit - start).ravel(), (limit - start).ravel()))
        solution = minimize(
            cost, np.zeros(start.size), jac=True, method="L-BFGS-B", bounds=bounds, options=options
        )
        return np.clip(start + solution.x.reshape(start.shape), -limit, limit)
