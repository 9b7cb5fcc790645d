"""ARX identification of T_u: least squares, order selection and confidence.

y(t) + a_1 y(t-1) + ... = b_0 u(t-n_k) + b_1 u(t-n_k-1) + ... + noise. Thesis (9.11), (9.12).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..estimation.consistency import Whiteness, residual_test
from ..models.system import System
from ..records import records


class Information(Enum):
    """Penalty on the number of coefficients."""

    AIC = "aic"
    BIC = "bic"
    """log(samples) a coefficient: consistent order selection."""


@dataclass(frozen=True, eq=False)
class ArxFit:
    """Identified ARX model and its uncertainty."""

    system: System
    na: int
    nb: int
    nk: int
    coefficients: Array
    """(a_1 .. a_na, b_0 .. b_(nb-1)), and their covariance."""
    covariance: Array
    noise_variance: float
    """Unbiased variance of the equation error."""
    n_samples: int
    whiteness: Whiteness | None
    """Test of the residuals, all experiments together; None for records too short for it."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to believe the covariance."""
        if self.whiteness is None or self.whiteness.is_uncorrelated:
            return ()
        return (
            f"the residuals are not white (p = {self.whiteness.p_value.min():.1g}), as with noise "
            "on the output: coefficients are biased, and their intervals too narrow",
        )

    @property
    def standard_errors(self) -> Array:
        return np.sqrt(np.diag(self.covariance))

    def confidence(self, sigmas: float = 1.96) -> Array:
        """(coefficients, 2), confidence interval of each; 1.96 standard errors are 95 %."""
        width = sigmas * self.standard_errors
        return np.column_stack((self.coefficients - width, self.coefficients + width))

    def response_deviation(self, omega: ArrayLike) -> Array:
        """Standard deviation of |T_u(e^{j omega})| to first order, at omega [rad/sample]."""
        z = np.exp(-1j * np.asarray(omega, dtype=np.float64))
        T, A = self.system.response(omega), np.polyval(self.system.a[::-1], z)
        by_a = [-T * z**i / A for i in range(1, self.na + 1)]
        by_b = [z ** (self.nk + i) / A for i in range(self.nb)]
        slopes = np.stack(by_a + by_b, axis=-1)
        slopes = (slopes * np.conj(T)[..., None]).real / np.abs(T)[..., None]  # of the magnitude
        return np.sqrt(np.einsum("...i,ij,...j->...", slopes, self.covariance, slopes))

    def score(self, criterion: Information) -> float:
        """Information criterion; the smallest is best. From the maximum-likelihood variance."""
        penalty = 2.0 if criterion is Information.AIC else np.log(self.n_samples)
        n, d = self.n_samples, self.na + self.nb
        return n * np.log(self.noise_variance * (n - d) / n) + penalty * d


@records("u", "y")
def fit_arx(
    u: Array,
    y: Array,
    sample_time: float,
    *,
    na: int,
    nb: int,
    nk: int,
    skip: int | None = None,
) -> ArxFit:
    """Least-squares fit; u, y: shape (N, m), m experiments from rest, all used together.

    skip: samples omitted at the start of each experiment; equal for all orders compared.

    Raises:
        ValueError: for orders that are negative or too large, or data that do not excite.
    """
    if na < 0 or nb < 1 or nk < 0:
        raise ValueError(f"orders must be na >= 0, nb >= 1, nk >= 0, got {na}, {nb}, {nk}")
    first = max(na, nk + nb - 1) if skip is None else skip
    if first < max(na, nk + nb - 1) or (len(y) - first) * y.shape[1] <= na + nb + 1:
        raise ValueError(
            f"orders {na}, {nb} and delay {nk} need more than {len(y)} samples of {y.shape[1]} "
            f"experiments from sample {first}"
        )
    rows = len(y)
    columns = [-y[first - i : rows - i] for i in range(1, na + 1)]
    columns += [u[first - nk - i : rows - nk - i] for i in range(nb)]
    regressor = np.stack([column.ravel() for column in columns], axis=1)
    target = y[first:].ravel()
    solution, _, rank, _ = np.linalg.lstsq(regressor, target)
    coefficients: Array = solution.astype(np.float64)
    if rank < regressor.shape[1]:
        raise ValueError(f"the data do not excite {na + nb} coefficients, only {rank}")
    residual = target - regressor @ coefficients
    variance = float(residual @ residual) / (len(target) - na - nb)
    b, a = np.concatenate((np.zeros(nk), coefficients[na:])), np.append(1.0, coefficients[:na])
    covariance = variance * np.linalg.inv(regressor.T @ regressor).astype(np.float64)
    noise = max(variance, np.finfo(float).tiny)
    system = System(b, a, sample_time)
    left = residual.reshape(-1, y.shape[1])
    return ArxFit(
        system, na, nb, nk, coefficients, covariance, noise, len(target), residual_test(left)
    )


@records("u", "y")
def select_arx(
    u: Array,
    y: Array,
    sample_time: float,
    *,
    na: Iterable[int] = range(4),
    nb: Iterable[int] = range(1, 4),
    nk: Iterable[int] = range(10),
    criterion: Information = Information.BIC,
) -> list[ArxFit]:
    """Fits of all given orders to the same samples, best first."""
    orders = [(i, j, k) for i in na for j in nb for k in nk]
    skip = max(max(i, k + j - 1) for i, j, k in orders)
    fits = [fit_arx(u, y, sample_time, na=i, nb=j, nk=k, skip=skip) for i, j, k in orders]
    return sorted(fits, key=lambda fit: fit.score(criterion))
