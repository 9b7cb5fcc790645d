"""Norm-optimal learning: the minimum of a quadratic criterion over the finite record, Algorithm 3.

Point to point: Freeman, "Constrained point-to-point iterative learning control with experimental
verification" (2012). Limits: Janssens, Pipeleers and Swevers, "A data-driven constrained
norm-optimal iterative learning control framework for LTI systems" (2013).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.system import Complex, System
from ..models.system_matrix import AnyModel, check_model
from ..records import as_number, as_real, as_whole, records
from .first_order import FirstOrderLaw
from .model_based import Response
from .quadratic import QuadraticCriterion, QuadraticProblem, Weight, conjugate_gradients, per_sample


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
        as_number(as_whole(self.n_samples, "n_samples"), "n_samples", 1)
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
        problem = self._problem
        given = (correction, problem.Wu, "correction"), (error, problem.We, "error")
        for signal, weight, name in given:
            if signal.shape != weight.shape:
                raise ValueError(f"{name} must have shape {weight.shape}, got {signal.shape}")
        return correction + problem.solve(problem.descent(correction, error))

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


_STEPS, _SOLVED = 60, 1e-4


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordOptimal(FirstOrderLaw):
    """Norm-optimal law for errors (N, p) and corrections (N, n), from a frequency response alone.

    minimise |F (e_k - T (u - u_k))|_W^2 + rho |S^-1 u|^2 + sigma |S^-1 (u - u_k)|^2

    T is the response G applied to a record that is at rest before and after, so products with T and
    its transpose are FFTs; conjugate gradients take a few dozen of them.
    """

    G: Response
    F: RecordFilter
    """Zero-phase filter that selects the learned part of the error; G: response to corrections."""
    output_weight: tuple[float, ...]
    input_size: tuple[float, ...]
    """(n,), diagonal of S, > 0; weights: (p,), square roots of W's diagonal."""
    correction_weight: float = 1e-3
    change_weight: float = 1e-2
    """rho and sigma, relative to the largest static gain of W^1/2 G S, squared."""
    tolerance: float | None = None
    """Residual at which conjugate gradients end, relative to the right side, or they fail. None:
    at 1e-4 or after 60 steps, less than the error of a model of an arm."""

    def __post_init__(self) -> None:
        for name in ("correction_weight", "change_weight"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be >= 0, got {getattr(self, name)}")
        if not self.correction_weight + self.change_weight > 0.0:
            raise ValueError("correction_weight and change_weight must not both be 0")
        if self.tolerance is not None and not 0.0 < self.tolerance < 1.0:
            raise ValueError(f"tolerance must be in (0, 1), got {self.tolerance}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n := len(self.input_size)) != n_columns:
            raise ValueError(f"the law has {n} inputs, the record {n_columns} columns")
        self.F.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        n = len(correction)
        weight, size = np.array(self.output_weight), np.array(self.input_size)
        omega = 2.0 * np.pi * np.fft.rfftfreq(2 * n)
        T = weight[:, None] * self.G.response(omega) * size
        T_H = np.conj(np.swapaxes(T, 1, 2))
        scale = np.linalg.norm(T[0], ord=2) ** 2
        rho, sigma = self.correction_weight * scale, self.change_weight * scale

        def through(response: Complex, signal: Array) -> Array:
            spectrum = np.fft.rfft(signal, 2 * n, axis=0)
            moved = (response @ spectrum[:, :, None])[:, :, 0]
            return np.fft.irfft(moved, 2 * n, axis=0)[:n]

        def normal(step: Array) -> Array:
            seen = self.F(self.F(through(T, step)))
            return through(T_H, seen) + (rho + sigma) * step

        right = through(T_H, self.F(self.F(error * weight))) - rho * correction / size
        tolerance = _SOLVED if self.tolerance is None else self.tolerance
        steps = _STEPS if self.tolerance is None else 10 * right.size
        found = np.zeros_like(right), right, (whole := float(np.vdot(right, right)))
        for found in islice(conjugate_gradients(normal, lambda r: r, right), steps):
            if found[2] <= tolerance**2 * whole:
                break
        x, _, power = found
        if self.tolerance is not None and power > tolerance**2 * whole:
            reached = np.sqrt(power / whole)
            raise RuntimeError(f"the step is known to {reached:.2g} only, not to {tolerance:.2g}")
        return correction + size * x
