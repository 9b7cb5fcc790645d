"""Prediction-error fit of polynomial models: ARMAX, output error and Box-Jenkins of any order.

    minimise over theta   sum_t e(t)^2

by damped Gauss-Newton with exact gradients, from several starts, for the sum has local minima.
Ljung, "System Identification", 2nd ed., chapters 7, 9 and 10. Starts are linear least squares,
refined by prefilters: Hannan and Rissanen (1982) regress on innovations of a long ARX model;
Steiglitz and McBride (1965) repeat an ARX fit on data filtered by its own denominator, which
tends to the output-error model. Where that ends in a local minimum, the reduction of a long ARX
model seldom does.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..estimation.consistency import Whiteness, independence, residual_test
from ..filters import recursion
from ..models.system import System
from ..records import records
from .polynomial import Information, Orders, Polynomials, delayed

_LONG = 20  # orders of the ARX model that gives innovations, at most
_REPEATED = 15
_REALISED = 10, 20, 40
"""Orders of the ARX models that are reduced: with little noise, to little bias. Without them six
output-error and Box-Jenkins fits of 300 random systems ended in a local minimum."""
_HANKEL = 80  # samples of an impulse response that a Hankel matrix covers, twice


@records("u", "y")
def starts(u: Array, y: Array, sample_time: float, orders: Orders) -> list[Polynomials]:
    """Models with stable predictors to start from."""
    dynamics = [_dynamics(u, y, orders, 0)]
    if orders.nf:
        dynamics.append(_dynamics(u, y, orders, _REPEATED))
        dynamics += [one for long in _REALISED for one in _realised(u, y, orders, long)]
    found = [_from_dynamics(*each, u, y, orders) for each in dynamics]
    models = [Polynomials(orders, theta, sample_time) for theta in found]
    return [model.with_stable_predictor() for model in models]


def _dynamics(u: Array, y: Array, orders: Orders, repeats: int) -> tuple[Array, Array]:
    """Denominator A F as one polynomial (1, ...), and the coefficients of B."""
    n, denominator = orders.na + orders.nf, np.ones(1)
    b = np.zeros(orders.nb)
    for _ in range(1 + repeats):
        prefilter = _stable(denominator)
        past_y, past_u = (recursion(np.ones(1), prefilter, s) for s in (y, u))
        columns = [-delayed(past_y, i) for i in range(1, n + 1)]
        columns += [delayed(past_u, orders.nk + i) for i in range(orders.nb)]
        found = _least_squares(columns, past_y)
        denominator, b = np.append(1.0, found[:n]), found[n:]
    return denominator, b


def _realised(u: Array, y: Array, orders: Orders, long: int) -> list[tuple[Array, Array]]:
    """As `_dynamics`, by Kung's realisation of the impulse response of a long ARX model.

    Empty where the record is too short for that model.
    """
    n, nk = orders.na + orders.nf, orders.nk
    if not (n < long and 3 * (long + nk) <= y.size):
        return []
    past = [delayed(y, i) for i in range(1, long + nk + 1)]
    found = _least_squares([*past, *(delayed(u, i) for i in range(nk, nk + long + 1))], y)
    a = _stable(np.concatenate(([1.0], -found[: long + nk])))
    f = _stable(_reduced(recursion(found[long + nk :], a, np.eye(2 * _HANKEL, 1))[:, 0], n))
    moved = recursion(np.ones(1), f, u)
    return [(f, _least_squares([delayed(moved, nk + i) for i in range(orders.nb)], y))]


def _reduced(impulse: Array, order: int) -> Array:
    """Denominator of the realisation of some order from the Hankel matrix of an impulse response.

    Kung (1978).
    """
    rows = np.arange(_HANKEL)
    U, size, _ = np.linalg.svd(impulse[rows[:, None] + rows])
    observed = U[:, :order] * np.sqrt(size[:order])
    A = np.linalg.lstsq(observed[:-1], observed[1:], rcond=None)[0]
    return np.poly(A).real.astype(np.float64)


def _from_dynamics(denominator: Array, b: Array, u: Array, y: Array, orders: Orders) -> Array:
    """theta: the denominator for A or F, which both have where it is split by slow poles."""
    f, a = _split(denominator, orders)
    numerator = np.concatenate((np.zeros(orders.nk), b))
    v = recursion(a, np.ones(1), y) - recursion(numerator, _stable(f), u)
    c, d = _noise(v, u, y, orders)
    return np.concatenate((a[1:], b, c, d, f[1:]))


def _split(denominator: Array, orders: Orders) -> tuple[Array, Array]:
    if not orders.na or not orders.nf:
        one = np.ones(1)
        return (denominator, one) if orders.nf else (one, denominator)
    f = np.zeros(orders.nf + 1)
    f[0] = 1.0
    return f, denominator[: orders.na + 1]


def _stable(f: Array) -> Array:
    orders = Orders(nb=1, nk=0, nf=len(f) - 1)
    return Polynomials(orders, np.append(1.0, f[1:]), 1.0).with_stable_predictor().parts["f"]


def _noise(v: Array, u: Array, y: Array, orders: Orders) -> tuple[Array, Array]:
    """C and D of the disturbance, with innovations of a long model of it."""
    if not orders.nc and not orders.nd:
        return np.zeros(0), np.zeros(0)
    long = min(_LONG, len(v) // 10)
    past = [delayed(v, i) for i in range(1, long + 1)]
    e = v - _predicted(past, v)
    columns = [-delayed(v, i) for i in range(1, orders.nd + 1)]
    columns += [delayed(e, i) for i in range(1, orders.nc + 1)]
    found = _least_squares(columns, v)
    return found[orders.nd :], found[: orders.nd]


def _predicted(columns: list[Array], target: Array) -> Array:
    if not columns:
        return np.zeros_like(target)
    found = _least_squares(columns, target)
    return np.stack(columns, axis=2) @ found


def _least_squares(columns: list[Array], target: Array) -> Array:
    regressor = np.stack([column.ravel() for column in columns], axis=1)
    return np.asarray(np.linalg.lstsq(regressor, target.ravel(), rcond=None)[0], dtype=np.float64)


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
    """Fit to u, y: shape (N, m), m experiments from rest, all used together."""
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
    J = model.gradient(u, y).reshape(e.size, -1)
    for _ in range(_STEPS):
        before = float(np.square(e).sum())
        found = _downhill(model, J, e, u, y, damping)
        if found is None:
            break
        model, e, damping = found
        J = model.gradient(u, y).reshape(e.size, -1)
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
