"""Model structures side by side on one record: the best order of each, and the best of all.

The delay follows from ARX models of high order; then each structure takes the order of the smallest
information criterion. Ljung, "System Identification", 2nd ed., 16.5 and 16.8.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from armside.arrays import Array

from ..models.state_space import StateSpace
from ..models.system import System
from ..records import records
from .arx import select_arx
from .first_order_lag import fit_of
from .polynomial import Information, Orders
from .polynomial_fit import PolynomialFit, fit_polynomial
from .subspace import SubspaceFit, rank_subspace_orders


@records("u", "y")
def rank_orders(
    u: Array,
    y: Array,
    sample_time: float,
    candidates: Iterable[Orders],
    criterion: Information = Information.BIC,
) -> list[PolynomialFit]:
    """Fits of all candidates to (u, y), shape (N, m), best first. BIC is Rissanen's MDL."""
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


class Structure(Enum):
    """Structure of a model and of its noise."""

    ARX = "arx"
    ARMAX = "armax"
    OUTPUT_ERROR = "oe"
    BOX_JENKINS = "bj"
    SUBSPACE = "subspace"


_ORDERS: dict[Structure, Callable[[int, int], Orders]] = {
    Structure.ARX: lambda n, nk: Orders.armax(n, n, 0, nk),
    Structure.ARMAX: lambda n, nk: Orders.armax(n, n, n, nk),
    Structure.OUTPUT_ERROR: lambda n, nk: Orders.output_error(n, n, nk),
    Structure.BOX_JENKINS: lambda n, nk: Orders.box_jenkins(n, n, n, n, nk),
}


@dataclass(frozen=True, eq=False)
class Candidate:
    """Best fit of one structure."""

    structure: Structure
    fit: PolynomialFit | SubspaceFit
    accuracy: float
    """Fit of the simulation on the record of the fit."""

    @property
    def system(self) -> System | StateSpace:
        """From u to y."""
        return self.fit.model.system

    @property
    def orders(self) -> str:
        """Orders in words."""
        if isinstance(self.fit, SubspaceFit):
            return f"{self.fit.model.order} states"
        given = self.fit.model.orders
        names = [name for name in ("na", "nb", "nc", "nd", "nf") if getattr(given, name)]
        return ", ".join(f"{name} {getattr(given, name)}" for name in (*names, "nk"))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to believe the model."""
        found = list(self.fit.warnings)
        if isinstance(self.fit, PolynomialFit) and not self.system.is_stable:
            found.append("the model is not stable: more data, or another order")
        if not self.accuracy > 0.0:
            found.append(
                "the simulated output is further from the record than a constant is: the record "
                "drifts, does not start at rest, or the system is not linear"
            )
        return tuple(found)


@records("u", "y", alike=False)
def compare_structures(
    u: Array,
    y: Array,
    sample_time: float,
    structures: Iterable[Structure] = tuple(Structure),
    *,
    largest_order: int = 4,
    largest_delay: int = 10,
) -> list[Candidate]:
    """Best fit of each structure to u (N, m) and y (N, p), the most trustworthy first.

    Fits without warnings come first, by BIC. With a warning it says little of
    the response from u to y, so those follow by the accuracy of simulation. Several inputs or
    outputs are for the subspace structure alone.
    """
    asked = list(structures)
    if (u.shape[1], y.shape[1]) != (1, 1):
        asked = [each for each in asked if each is Structure.SUBSPACE]
    if not asked:
        raise ValueError("several inputs or outputs need the structure subspace")
    delay = 0 if u.shape[1] > 1 or y.shape[1] > 1 else _delay(u, y, sample_time, largest_delay)
    found = []
    for each in asked:
        if each is Structure.SUBSPACE:
            sizes = range(1, largest_order + delay + 1)
            horizon = max(10, 2 * len(sizes))
            best, *_ = rank_subspace_orders(
                u, y, sample_time, sizes, horizon=horizon, feedthrough=delay == 0
            )
        else:
            sizes = [_ORDERS[each](n, delay) for n in range(1, largest_order + 1)]
            best = _best(u, y, sample_time, sizes)
        found.append(Candidate(each, best, fit_of(best.model.system, u, y)))
    sound = [one for one in found if not one.warnings]
    others = [one for one in found if one.warnings]
    sound.sort(key=lambda one: one.fit.score(Information.BIC))
    return sound + sorted(others, key=lambda one: -one.accuracy)


def _delay(u: Array, y: Array, sample_time: float, largest: int) -> int:
    """Of the ARX model of order 4 with the smallest BIC; of a lower order where noise is too
    small, or the record too short, to tell its coefficients apart."""
    reason = None
    for order in (4, 2, 1):
        try:
            return select_arx(
                u, y, sample_time, na=[order], nb=[order], nk=range(largest + 1)
            )[0].model.orders.nk  # fmt: skip
        except ValueError as error:
            reason = error
    assert reason is not None
    raise reason


def _best(u: Array, y: Array, sample_time: float, sizes: list[Orders]) -> PolynomialFit:
    """Orders that the data do not excite are left out; of none, the reason is raised."""
    fits, reason = list[PolynomialFit](), None
    for orders in sizes:
        try:
            fits.append(fit_polynomial(u, y, sample_time, orders))
        except ValueError as error:
            reason = error
    if not fits:
        assert reason is not None
        raise reason
    return min(fits, key=lambda fit: fit.score(Information.BIC))
