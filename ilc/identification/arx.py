"""ARX identification of T_u: least squares, order selection and confidence.

y(t) + a_1 y(t-1) + ... = b_0 u(t-n_k) + b_1 u(t-n_k-1) + ... + noise. Thesis (9.11), (9.12).
"""

from collections.abc import Iterable

import numpy as np

from armside.arrays import Array

from ..estimation.consistency import residual_test
from ..records import records
from .polynomial import Information, Orders, Polynomials
from .polynomial_fit import PolynomialFit


class ArxFit(PolynomialFit):
    """Identified ARX model, and its uncertainty for white equation error."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to believe the covariance."""
        if self.whiteness is None or self.whiteness.is_uncorrelated:
            return ()
        return (
            f"the residuals are not white (p = {self.whiteness.p_value.min():.1g}), as with noise "
            "on the output: coefficients are biased, and their intervals too narrow",
        )


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
    covariance = variance * np.linalg.inv(regressor.T @ regressor).astype(np.float64)
    noise = max(variance, np.finfo(float).tiny)
    left = residual_test(residual.reshape(-1, y.shape[1]))
    model = Polynomials(Orders.armax(na, nb, 0, nk), coefficients, sample_time)
    return ArxFit(model, covariance, noise, len(target), left, None)


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
