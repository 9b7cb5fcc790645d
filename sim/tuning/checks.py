"""Check of whole numbers."""

import operator
from typing import Any

import numpy as np


def whole(name: str, value: Any, low: int, high: int | None = None) -> int:
    """A whole number from `low` to `high`, of Python or NumPy.

    Raises ValueError for anything else, True and False among it.
    """
    try:
        number = None if isinstance(value, bool | np.bool_) else operator.index(value)
    except TypeError:
        number = None
    if number is None or number < low or (high is not None and number > high):
        limits = f">= {low}" if high is None else f"in {low} .. {high}"
        raise ValueError(f"{name} must be a whole number {limits}, got {value!r}")
    return number
