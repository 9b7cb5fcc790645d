"""The array type of all packages, and a check of records of samples."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""float64; docstrings give shape and unit."""


def freeze_rows(record: Any, *names: str) -> None:
    """Make arrays of a record read-only; ValueError unless each has a row for each `time`."""
    for name in names:
        value = getattr(record, name)
        if len(value) != len(record.time):
            raise ValueError(f"{name} must have {len(record.time)} rows, got {len(value)}")
        value.setflags(write=False)
