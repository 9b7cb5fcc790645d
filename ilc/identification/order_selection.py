"""Order of a polynomial model: by information criteria, or by the error on another record."""

from collections.abc import Iterable

import numpy as np

from armside.arrays import Array

from ..records import records
from .arx import Information
from .polynomial import Orders
from .polynomial_fit import PolynomialFit, fit_polynomial


@records("u", "y")
def rank_orders(
    u: Array,
    y: Array,
    sample_time: float,
    candidates: Iterable[Orders],
    criterion: Information = Information.BIC,
) -> list[PolynomialFit]:
    """Fits of all candidates to (u, y), shape (N, m), best first. BIC is Rissanen's MDL.

    Raises ValueError without candidates, and as `fit_polynomial`.
    """
    fits = [fit_polynomial(u, y, sample_time, orders) for orders in candidates]
    if not fits:
        raise ValueError("candidates must not be empty")
    return sorted(fits, key=lambda fit: fit.score(criterion))


@records("u", "y")
def rank_by_validation(fits: Iterable[PolynomialFit], u: Array, y: Array) -> list[PolynomialFit]:
    """Fits by the prediction error on a record (N, m) that they were not fitted to, best first."""
    return sorted(fits, key=lambda fit: validation_error(fit, u, y))


@records("u", "y")
def validation_error(fit: PolynomialFit, u: Array, y: Array) -> float:
    """RMS of the prediction error on a record (N, m)."""
    return float(np.sqrt(np.square(fit.model.prediction_error(u, y)).mean()))
