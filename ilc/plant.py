"""Interface between learning and a plant: a correction in, the measured output back."""

from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

Result_co = TypeVar("Result_co", covariant=True)


class Plant(Protocol[Result_co]):
    """One repetition of the task, always from the same initial state.

    `run` returns the measured output, shape (N, n), or a record that holds it; for a record, the
    learning loop is given a function that reads the output from it.
    """

    def run(self, correction: Array, /) -> Result_co:
        """Repeat the task with u_k = correction, shape (N, n)."""
        ...


def as_record(signal: ArrayLike, name: str) -> Array:
    """Signal as a non-empty, finite array of shape (N, n), time along the first axis.

    Raises ValueError, with `name`, for any other signal.
    """
    values = np.asarray(signal, dtype=np.float64)
    if values.ndim != 2 or 0 in values.shape:
        raise ValueError(f"{name} must have shape (N, n) with N, n >= 1, got {values.shape}")
    if not np.isfinite(values).all():
        i, j = np.argwhere(~np.isfinite(values))[0]
        raise ValueError(f"{name} must be finite, got {values[i, j]} at sample {i}, column {j}")
    return values
