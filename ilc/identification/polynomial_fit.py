"""Prediction-error fit of polynomial models: ARMAX, output error and Box-Jenkins of any order.

    minimise over theta   sum_t e(t)^2

by damped Gauss-Newton with exact gradients, from several starts (`polynomial_start`), for the sum
has local minima. Ljung, "System Identification", 2nd ed., chapters 7, 9 and 10.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..estimation.consistency import Whiteness, residual_test
from ..models.system import System
from ..records import records
from .arx import Information
from .polynomial import Orders, Polynomials
from .polynomial_start import starts
from .residual_tests import independence

_STEPS = 100
_CONVERGED = 1e-10  # relative decrease of the sum of squares that ends the search
_LARGEST = 1.0 - 1e-9  # modulus of a zero that a step mirrors into the unit circle
_REJECTED = 0.01  # p-value


@dataclass(frozen=True, eq=False)
class PolynomialFit:
    """Identified model, its uncertainty, and tests of its residuals."""

    model: Polynomials
    covariance: Array
    """(d, d) of theta; of the truth where the noise model is right."""
    noise_variance: float
    """Unbiased variance of e."""
    n_samples: int
    whiteness: Whiteness | None
    """Test of the prediction errors; None for records too short for it."""
    independence: float | None
    """p-value that prediction errors are uncorrelated with the input; None as above."""

    @property
    def system(self) -> System:
        """From u to y."""
        return self.model.system

    @property
    def standard_errors(self) -> Array:
        return np.sqrt(np.diag(self.covariance))

    def confidence(self, sigmas: float = 1.96) -> Array:
        """(d, 2), confidence intervals of theta; 1.96 standard errors are 95 %."""
        width = sigmas * self.standard_errors
        return np.column_stack((self.model.theta - width, self.model.theta + width))

    def response_deviation(self, omega: ArrayLike) -> Array:
        """Standard deviation of |response| to first order, at omega [rad/sample]."""
        G = self.system.response(omega)
        slopes = self.model.response_slopes(omega) * np.conj(G)[..., None]
        slopes = slopes.real / np.abs(G)[..., None]
        return np.sqrt(np.einsum("...i,ij,...j->...", slopes, self.covariance, slopes))

    def score(self, criterion: Information) -> float:
        """Information criterion; the smallest is best. From the maximum-likelihood variance."""
        n, d = self.n_samples, self.model.orders.count
        penalty = 2.0 if criterion is Information.AIC else np.log(n)
        return n * np.log(self.noise_variance * (n - d) / n) + penalty * d

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to believe the dynamics or their intervals."""
        found, orders = [], self.model.orders
        if self.independence is not None and self.independence < _REJECTED:
            found.append(
                f"the input explains part of the residuals (p = {self.independence:.1g}): the "
                "order is too low, the delay too long, or the system not linear"
            )
        if self.whiteness is not None and not self.whiteness.is_uncorrelated:
            result = "coefficients are biased" if orders.na else "their intervals are wrong"
            found.append(
                f"the residuals are not white (p = {self.whiteness.p_value.min():.1g}): the model "
                f"of the noise is wrong and {result}"
            )
        return tuple(found)


@records("u", "y")
def fit_polynomial(u: Array, y: Array, sample_time: float, orders: Orders) -> PolynomialFit:
    """Fit to u, y: shape (N, m), m experiments from rest, all used together.

    Raises:
        ValueError: for records too short for the orders, or data that do not excite them.
    """
    rows = y.size - orders.count
    if rows <= orders.count + orders.nk:
        raise ValueError(f"{orders.count} coefficients need more than {y.size} samples")
    ends = [_search(start, u, y) for start in starts(u, y, sample_time, orders)]
    model, J, e = min(ends, key=lambda each: float(np.square(each[2]).sum()))
    size = np.sqrt(np.square(J).sum(axis=0))
    if not size.all() or np.linalg.matrix_rank(J / size) < len(size):
        raise ValueError(f"the data do not excite {orders.count} coefficients of {orders}")
    information = J.T @ J
    variance = max(float(e.ravel() @ e.ravel()) / rows, np.finfo(float).tiny)
    covariance = variance * np.linalg.inv(information).astype(np.float64)
    tests = residual_test(e), independence(e, u)
    return PolynomialFit(model, covariance, variance, y.size, *tests)


def _search(start: Polynomials, u: Array, y: Array) -> tuple[Polynomials, Array, Array]:
    """Model at the minimum, gradient (N m, d) and prediction error (N, m) there."""
    model, damping = start, 1e-3
    e = model.prediction_error(u, y)
    J = _flat(model.gradient(u, y))
    for _ in range(_STEPS):
        before = float(np.square(e).sum())
        found = _downhill(model, J, e, u, y, damping)
        if found is None:
            break
        model, e, damping = found
        J = _flat(model.gradient(u, y))
        if before - float(np.square(e).sum()) <= _CONVERGED * before:
            break
    return model, J, e


def _downhill(
    model: Polynomials, J: Array, e: Array, u: Array, y: Array, damping: float
) -> tuple[Polynomials, Array, float] | None:
    """Next model with a stable predictor and a smaller sum, its error, and the damping."""
    size = np.maximum(np.sqrt(np.square(J).sum(axis=0)), np.finfo(float).tiny)
    H, slope, before = (J / size).T @ (J / size), (J / size).T @ e.ravel(), np.square(e).sum()
    while damping < 1e8:
        step = np.linalg.solve(H + damping * np.eye(len(H)), slope) / size
        tried = Polynomials(model.orders, model.theta - step, model.sample_time)
        if not tried.is_predictor_stable:
            tried = tried.with_stable_predictor(_LARGEST)
        if tried.is_predictor_stable:
            left = tried.prediction_error(u, y)
            if np.square(left).sum() < before:
                return tried, left, max(damping / 10.0, 1e-12)
        damping = max(10.0 * damping, 1e-6)
    return None


def _flat(gradient: Array) -> Array:
    return gradient.reshape(-1, gradient.shape[2])
