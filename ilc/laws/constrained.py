"""Norm-optimal learning with bounds on the correction: one quadratic programme an iteration."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..records import records
from .norm_optimal import NormOptimal
from .quadratic import Weight, per_sample


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
        if not (np.asarray(self.limit, dtype=np.float64) > 0.0).all():
            raise ValueError("limit must be > 0")
        per_sample(self.limit, self.n_samples, self.n_columns, "limit")

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        free = super().__call__(correction, error)
        limit = per_sample(self.limit, self.n_samples, self.n_columns, "limit")
        if (np.abs(free) <= limit).all():
            return free
        return self._within(limit, free, correction, error)

    def _within(self, limit: Array, free: Array, correction: Array, error: Array) -> Array:
        from scipy.optimize import minimize

        problem, shape = self._problem, free.shape
        free_error = error + self.T_u.simulate(correction)

        def cost(flat: Array) -> tuple[float, Array]:
            u = flat.reshape(shape)
            residual = problem.filtered(free_error - self.T_u.simulate(u))
            change = u - correction
            pulled = problem.Wu * u + problem.Wd * change
            value = np.vdot(residual, problem.We * residual) + np.vdot(u, problem.Wu * u)
            value += np.vdot(change, problem.Wd * change)
            return 0.5 * float(value), (pulled - problem.weighted_back(residual)).ravel()

        start, bound = np.clip(free, -limit, limit).ravel(), limit.ravel()
        # The gradient at u = 0 sets the scale.
        scale = np.abs(cost(np.zeros_like(start))[1]).max()
        options = {"ftol": 0.0, "gtol": 0.1 * self.tolerance * scale, "maxcor": 30}
        options |= {"maxiter": 5000, "maxfun": 20000}
        bounds = np.column_stack((-bound, bound))
        solution = minimize(
            cost, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options
        )
        residual = np.clip(solution.x - cost(solution.x)[1], -bound, bound) - solution.x
        if np.abs(residual).max() > self.tolerance * scale:
            reached = np.abs(residual).max() / scale
            raise RuntimeError(
                f"the quadratic programme stopped at a projected gradient of {reached:.2g}, not "
                f"{self.tolerance:.2g}: {solution.message}"
            )
        return solution.x.reshape(shape)
