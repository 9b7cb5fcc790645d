"""What ILC knows of the world: something that runs a correction and returns what came out."""

from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

Result_co = TypeVar("Result_co", covariant=True)


class Plant(Protocol[Result_co]):
    """One repetition of the task, always from the same initial state.

    `run` returns the measured output, shape (N, n), or any record that holds it; in the second
    case the learning loop is told how to read the output from the record.
    """

    def run(self, correction: Array, /) -> Result_co:
        """Repeat the task with u_k = correction, shape (N, n)."""
        ...


def as_record(signal: ArrayLike, name: str) -> Array:
    """A finite signal of shape (N, n), time along the first axis.

    Raises:
        ValueError: wrong number of axes, an empty record or a value that is not finite.
    """
    values = np.asarray(signal, dtype=np.float64)
    if values.ndim != 2 or 0 in values.shape:
        raise ValueError(f"{name} must have shape (N, n) with N, n >= 1, got {values.shape}")
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        raise ValueError(
            f"{name} must be finite, got {values[row, column]} at sample {row}, column {column}"
        )
    return values
