"""T_u identified from learning data: sums over experiments of u_K and of y_K - y_0.

Friction does not depend on the correction, so a sum over several speeds averages it. At rest it
holds a motor in place, which is no linear dynamics: records end with the first motion that ends.
Thesis (9.11).
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_record
from .first_order import FirstOrderModel, fit_first_order


class LearningRecord(NamedTuple):
    """One learning experiment: its last correction u_K, first error e_0 and last e_K, (N, n)."""

    correction: ArrayLike
    first_error: ArrayLike
    last_error: ArrayLike
    motion_end: int
    """Sample at which the reference comes to rest."""


def learning_data(
    records: Iterable[LearningRecord], motors: Sequence[int] | None = None
) -> tuple[Array, Array]:
    """(u, y) = (sum of u_K, sum of e_0 - e_K) of some motors, shape (N, motors). Thesis (9.11).

    N: the smallest `motion_end`. motors: columns, counted from 0; None: all. Differences of errors
    are formed and summed in the precision in which they are stored.

    Raises:
        ValueError: if there are no records, or no samples of motion.
    """
    records = list(records)
    if not records:
        raise ValueError("learning data must hold at least one record")
    n = min(record.motion_end for record in records)
    if n < 1:
        raise ValueError(f"motion_end must be >= 1 sample, got {n}")
    columns = slice(None) if motors is None else list(motors)

    def part(signal: ArrayLike) -> Array:
        as_record(signal, "a learning record")
        return np.asarray(signal)[:n, columns]

    u = np.asarray(sum(part(r.correction).astype(np.float64) for r in records))
    y = np.asarray(sum(part(r.first_error) - part(r.last_error) for r in records))
    return u, y.astype(np.float64)


def identify(
    records: Iterable[LearningRecord], sample_time: float, motors: Sequence[int] | None = None
) -> FirstOrderModel:
    """One first-order T_u for some motors together, by output error on `learning_data`."""
    u, y = learning_data(records, motors)
    return fit_first_order(u, y, sample_time)
