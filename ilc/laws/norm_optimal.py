"""Algorithm 3: norm-optimal learning, a quadratic criterion over the finite record."""

from dataclasses import dataclass, field
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex, System, require_stable
from ..models.system_matrix import Model, SystemMatrix, check_inputs
from ..records import records
from .law import FirstOrderLaw

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
class BandedProblem:
    """Quadratic criterion as least squares, min ||M v - b||, in a variable v that makes M banded.

    Each input has a common denominator: u_j = a_j(q) v_j and y_i = sum_j b_ij(q) v_j. In v both
    u = A v and F y = FB v are banded, with a bandwidth of the order of the model times the number
    of motors, so design and iteration cost O(N) and no N x N matrix appears. Rows are ordered
    sample by sample, motors within a sample.
    """

    A: Any
    M: Any
    """sqrt(We) FB above sqrt(Wu + Wd) A, sparse (2 N n, N n); A and F are sparse (N n, N n)."""
    F: Any
    We: Array
    """Diagonal of the error weight, (N n,); likewise Wu and Wd."""
    Wu: Array
    Wd: Array

    @classmethod
    def build(
        cls, T_u: Model, criterion: QuadraticCriterion, n_samples: int, n_columns: int
    ) -> "BandedProblem":
        """Matrices for records of shape (N, n)."""
        from scipy.sparse import csc_array, diags_array, vstack

        a, b = _common_denominators(T_u, n_columns)
        taps = np.asarray(criterion.error_filter)[:, None, None]
        F = _block_toeplitz(taps * np.eye(n_columns), n_samples)
        A = _block_toeplitz(a, n_samples)
        FB = F @ _block_toeplitz(b, n_samples)
        weights = [(getattr(criterion, name), name) for name in ("error", "correction", "change")]
        We, Wu, Wd = (
            per_sample(weight, n_samples, n_columns, f"the weight of the {name}").ravel()
            for weight, name in weights
        )
        M = vstack((diags_array(np.sqrt(We)) @ FB, diags_array(np.sqrt(Wu + Wd)) @ A))
        return cls(A, csc_array(M), F, We, Wu, Wd)

    def right_side(self, free_error: Array, correction: Array) -> Array:
        """b; free_error is the error with u = 0, flat."""
        weight = np.sqrt(self.Wu + self.Wd)
        pull = np.divide(self.Wd * correction, weight, out=np.zeros_like(weight), where=weight > 0)
        return np.concatenate((np.sqrt(self.We) * (self.F @ free_error), pull))


class LeastSquares:
    """min ||M v - b|| for a banded M, factored once.

    Sparse LU of the augmented system [[s I, M], [M', 0]] [r/s; v] = [b; 0]: normal equations would
    square the condition number, which several slow poles already make large. A small s keeps the
    condition near that of M.
    """

    SCALE = 1e-5
    """s relative to the largest entry of M."""

    def __init__(self, M: Any, n_columns: int) -> None:
        from scipy.sparse import block_array, csc_array, eye_array
        from scipy.sparse.linalg import splu

        rows, self._size = M.shape
        scale = self.SCALE * np.abs(M.data).max()
        augmented = csc_array(block_array([[scale * eye_array(rows), M], [M.T, None]]))
        # Time-ordered rows and columns make the augmented matrix banded as well.
        blocks = np.arange(rows + self._size).reshape(3, -1, n_columns)
        self._order = np.ascontiguousarray(blocks.transpose(1, 0, 2)).ravel()
        self._augmented = csc_array(augmented[self._order][:, self._order])
        try:
            self._lu = splu(self._augmented, permc_spec="NATURAL")
        except RuntimeError as error:  # exactly singular
            remedy = "raise the weight of the correction or of its change"
            message = f"the criterion does not determine the correction: {remedy}"
            raise ValueError(message) from error

    def solve(self, b: Array) -> Array:
        right = np.concatenate((b, np.zeros(self._size)))[self._order]
        x = self._lu.solve(right)
        x += self._lu.solve(right - self._augmented @ x)  # one refinement: two or three digits
        full = np.empty_like(x)
        full[self._order] = x
        return full[-self._size :]


@dataclass(frozen=True, kw_only=True, eq=False)
class NormOptimal(FirstOrderLaw):
    """Minimum of a `QuadraticCriterion` in every iteration.

    T_u: one system, used for each motor, or a matrix of systems for coupled motors. Equal to
    Q = (T'WT + Wu + Wd)^-1 (T'WT + Wd), L = (T'WT + Wd)^-1 T'W in the lifted form, without
    building T.
    """

    T_u: Model
    n_samples: int
    n_columns: int = 1
    criterion: QuadraticCriterion = field(
        default_factory=lambda: QuadraticCriterion(correction=1e-4, change=1e-2)
    )

    def __post_init__(self) -> None:
        require_stable(self.T_u, "T_u")
        problem = BandedProblem.build(self.T_u, self.criterion, self.n_samples, self.n_columns)
        object.__setattr__(self, "_problem", problem)
        object.__setattr__(self, "_solver", LeastSquares(problem.M, self.n_columns))

    _problem: BandedProblem = field(init=False, repr=False)
    _solver: LeastSquares = field(init=False, repr=False)

    def check(self, n_samples: int, n_columns: int) -> None:
        designed, given = (self.n_samples, self.n_columns), (n_samples, n_columns)
        if given != designed:
            raise ValueError(f"the law was designed for records of shape {designed}, got {given}")

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        free_error = (error + self.T_u.simulate(correction)).ravel()
        v = self._solver.solve(self._problem.right_side(free_error, correction.ravel()))
        return (self._problem.A @ v).reshape(correction.shape)

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


def _common_denominators(T_u: Model, n: int) -> tuple[Array, Array]:
    """Coefficient matrices (lags, n, n): a of u = a(q) v, diagonal, and b of y = b(q) v."""
    if isinstance(T_u, System):
        T_u = SystemMatrix.diagonal([T_u] * n)
    check_inputs(T_u, n)
    denominators, numerators = [], {}
    for j in range(n):
        column = [T_u.entries[i][j] for i in range(n)]
        different: list[Array] = []
        for system in column:
            if system.b.any() and not any(np.array_equal(system.a, a) for a in different):
                different.append(system.a)
        common = _product(different)
        denominators.append(common)
        for i, system in enumerate(column):
            if system.b.any():
                others = [a for a in different if not np.array_equal(a, system.a)]
                numerators[i, j] = np.convolve(system.b, _product(others))
    a = np.zeros((max(map(len, denominators)), n, n))
    b = np.zeros((max((len(p) for p in numerators.values()), default=1), n, n))
    for j, p in enumerate(denominators):
        a[: len(p), j, j] = p
    for (i, j), p in numerators.items():
        b[: len(p), i, j] = p
    return a, b


def _product(polynomials: list[Array]) -> Array:
    return reduce(np.convolve, polynomials, np.ones(1))


def _block_toeplitz(lags: Array, n_samples: int) -> Any:
    """Sparse lower block-triangular matrix of sum_l lags[l] q^-l on N samples."""
    from scipy.sparse import csr_array, eye_array, kron

    size = n_samples * lags.shape[1]
    total = csr_array((size, size))
    for lag, block in enumerate(lags[:n_samples]):
        if block.any():
            total = total + kron(eye_array(n_samples, k=-lag), csr_array(block), format="csr")
    return csr_array(total)


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
