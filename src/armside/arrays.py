"""The array type of all packages, and checks of arguments and of records of samples."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

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


def real_array(name: str, value: ArrayLike, *shape: int) -> Array:
    """A float64 array of an array-like, whose last axes have the lengths `shape`.

    Raises:
        ValueError: complex numbers, masked entries, text, or another shape.
    """
    given = value if isinstance(value, np.ndarray) else np.asarray(value)
    if given.dtype.kind not in "fiub" or isinstance(given, np.ma.MaskedArray):
        kind = "a masked array" if isinstance(given, np.ma.MaskedArray) else str(given.dtype)
        raise ValueError(f"{name} must be real numbers, got {kind}")
    if shape and given.shape[-len(shape) :] != shape:
        needed = ", ".join(["...", *map(str, shape)])
        raise ValueError(f"{name} must have shape ({needed}), got {given.shape}")
    return np.asarray(given, dtype=np.float64)


def finite_array(name: str, value: ArrayLike, *shape: int) -> Array:
    """Like `real_array`, without NaN and infinities."""
    array = real_array(name, value, *shape)
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got NaN or infinity")
    return array


def check_out(out: Any, shape: tuple[int, ...]) -> None:
    """Refuse an `out=` that is no float64 array of a shape."""
    if not isinstance(out, np.ndarray):
        raise ValueError(f"out must be float64 of shape {shape}, got {type(out).__name__}")
    if out.shape != shape or out.dtype != np.float64:
        raise ValueError(f"out must be float64 of shape {shape}, got {out.dtype} of {out.shape}")
