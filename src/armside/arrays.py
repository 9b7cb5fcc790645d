"""The array type of all packages, and a check of records of samples."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""float64; docstrings give shape and unit."""


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Contiguous view, or copy, of an array that cannot be written to.

    For arguments of compiled functions: numba compiles one for arrays that can be written to and
    another, with the same result, for those that cannot.
    """
    view = np.ascontiguousarray(array).view()
    view.setflags(write=False)
    return view


def freeze_rows(record: Any, *names: str) -> None:
    """Make arrays of a record read-only; ValueError unless each has a row for each `time`."""
    for name in names:
        value = getattr(record, name)
        if len(value) != len(record.time):
            raise ValueError(f"{name} must have {len(record.time)} rows, got {len(value)}")
        value.setflags(write=False)
