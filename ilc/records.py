"""Gate of the package: records, float64 arrays (N, n) that public functions take as their signals.

A function declares its records with `records`; they then pass `as_record`, or `as_samples` where
values that are not finite have a meaning, before the function sees them.
"""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, shown

P = ParamSpec("P")
R = TypeVar("R")


def as_real(values: ArrayLike, name: str) -> Array:
    """Values as float64, of any shape. ValueError for masked, complex or non-numeric ones."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name} must not be masked: mark or repair missing samples")
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{name} must be real numbers, got {array.dtype}")
    return array.astype(np.float64, copy=False)


def as_number(value: Any, name: str, low: float = -np.inf, high: float = np.inf) -> float:
    """One finite number. ValueError for an array, text or a truth value, and outside [low, high],
    where a bound of 0 itself does not count."""
    number = as_real(value, name)
    if number.ndim or not np.isfinite(number):
        raise ValueError(f"{name} must be one finite number, got {shown(value)}")
    if not low <= number <= high or (low == 0.0 and number == 0.0):
        below = "" if np.isinf(high) else f" and <= {high:g}"
        bound = f"{'>' if low == 0.0 else '>='} {low:g}{below}"
        raise ValueError(f"{name} must be {bound}, got {value}")
    return float(number)


def as_whole(values: ArrayLike, name: str) -> NDArray[np.int64]:
    """Values as whole numbers, of any shape. ValueError for what is none, such as a mask."""
    given = np.asarray(values)
    whole = given.dtype.kind in "iu" or (given.dtype.kind == "f" and (given == given.round()).all())
    whole = whole and bool(np.isfinite(given).all())
    if not whole:
        raise ValueError(f"{name} must be a whole number of samples, got {shown(values)}")
    return given.astype(np.int64)


def as_samples(signal: ArrayLike, name: str) -> Array:
    """Signal as a non-empty array of shape (N, n), perhaps with values that are not finite."""
    values = as_real(signal, name)
    if values.ndim != 2 or 0 in values.shape:
        raise ValueError(f"{name} must have shape (N, n) with N, n >= 1, got {values.shape}")
    return values


def as_record(signal: ArrayLike, name: str) -> Array:
    """Signal as a non-empty, finite array of shape (N, n), time along the first axis."""
    values = as_samples(signal, name)
    if not np.isfinite(values).all():
        i, j = np.argwhere(~np.isfinite(values))[0]
        raise ValueError(f"{name} must be finite, got {values[i, j]} at sample {i}, column {j}")
    return values


def as_measured(signal: ArrayLike, name: str) -> Array:
    """Signal as a non-empty array of shape (N, n), NaN where a measurement is missing."""
    values = as_samples(signal, name)
    if np.isinf(values).any():
        i, j = np.argwhere(np.isinf(values))[0]
        raise ValueError(f"{name} must not be infinite, got {values[i, j]} at sample {i}")
    return values


Gate = Callable[[Any, str], Array]


def records(
    *names: str, gate: Gate = as_record, alike: bool = True
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorator: the named arguments pass the gate.

    Several must have one shape, or at least equally many samples if they need not be alike.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        parameters = list(signature(function).parameters)

        @wraps(function)
        def gated(*args: P.args, **kwargs: P.kwargs) -> R:
            given = dict(zip(parameters, args, strict=False)) | kwargs
            passed = {name: gate(given[name], name) for name in names if name in given}
            shapes = [record.shape if alike else record.shape[0] for record in passed.values()]
            if len(set(shapes)) > 1:
                same = "one shape" if alike else "equally many samples"
                found = " and ".join(map(str, shapes))
                raise ValueError(f"{' and '.join(passed)} must have {same}, got {found}")
            placed = [passed.get(p, value) for p, value in zip(parameters, args, strict=False)]
            extra = args[len(parameters) :]
            named = {name: passed.get(name, value) for name, value in kwargs.items()}
            return function(*placed, *extra, **named)  # type: ignore[arg-type]

        gated.__records__ = (*names, *getattr(function, "__records__", ()))  # type: ignore[attr-defined]
        return gated

    return decorate
