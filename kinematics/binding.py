"""A compiled module as one Python function: the short way for arrays, the careful way for all else.

The short way is what a control loop pays for: no conversion, no copy, one attribute of one
argument looked at. What it cannot take falls through to the careful way, which converts, copies,
handles batches, and explains what is wrong.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from armside.arrays import Array

_FALL_THROUGH = (AttributeError, TypeError, ValueError)


def bind(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    """The function of a generated module whose arguments are vectors of given sizes.

    The result takes a batch as one leading axis of every argument, and `out=`.
    """
    makers = {1: _one, 2: _two, 3: _three}
    return makers[len(sizes)](module, sizes, shape)


def _one(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    one, empty, careful = module.one, np.empty, _careful(module, sizes, shape)

    def function(a: Any, /, out: Array | None = None) -> Array:
        try:
            if a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, result)
                return result
        except _FALL_THROUGH:
            pass
        return careful(out, a)

    return function


def _two(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    one, empty, careful = module.one, np.empty, _careful(module, sizes, shape)

    def function(a: Any, b: Any, /, out: Array | None = None) -> Array:
        try:
            if a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, b, result)
                return result
        except _FALL_THROUGH:
            pass
        return careful(out, a, b)

    return function


def _three(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    one, empty, careful = module.one, np.empty, _careful(module, sizes, shape)

    def function(a: Any, b: Any, c: Any, /, out: Array | None = None) -> Array:
        try:
            if a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, b, c, result)
                return result
        except _FALL_THROUGH:
            pass
        return careful(out, a, b, c)

    return function


def _careful(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    def function(out: Array | None, *arguments: Any) -> Array:
        arrays = [np.ascontiguousarray(a, dtype=np.float64) for a in arguments]
        batch = arrays[0].shape[:-1]
        if len(batch) > 1 or any(
            a.shape != (*batch, n) for a, n in zip(arrays, sizes, strict=True)
        ):
            given = ", ".join(str(a.shape) for a in arrays)
            single = ", ".join(f"({n},)" for n in sizes)
            many = ", ".join(f"(N, {n})" for n in sizes)
            raise ValueError(f"arguments must have shapes {single} or {many}; got {given}")
        expected = (*batch, *shape)
        if out is not None and (out.shape != expected or out.dtype != np.float64):
            raise ValueError(
                f"out must be float64 of shape {expected}, got {out.dtype} of {out.shape}"
            )
        compute = module.many if batch else module.one
        if out is not None and out.flags.c_contiguous and out.flags.writeable:
            compute(*_writable(arrays), out)
            return out
        result = np.empty(expected)
        compute(*_writable(arrays), result)
        if out is None:
            return result
        out[...] = result
        return out

    return function


def _writable(arrays: list[Array]) -> list[Array]:
    """Read-only arguments are copied: compiled signatures know one kind of array."""
    return [a if a.flags.writeable else a.copy() for a in arrays]
