"""Straight-line programs as native functions of arrays, generated on first use and kept on disk.

A function has two paths. The fast one is the cost of a call in a control loop: no conversion, no
copy, one attribute of one argument is read. Arguments that it cannot take go to the general path,
which converts, copies, handles batches, and says which shapes are allowed.
"""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.arrays import Array

from .cache import cached_module

if TYPE_CHECKING:
    from .equations.program import StraightLineProgram

_NOT_FAST = (AttributeError, TypeError, ValueError)


def native_module(
    name: str,
    key: str,
    program: "Callable[[], StraightLineProgram]",
    folder: Path | str | None = None,
) -> ModuleType:
    """Compiled module of a program, which is built only when `key` is not in the cache yet."""

    def source() -> str:
        from .codegen import numba_module

        return numba_module(program())

    return cached_module(name, key, source, folder)


def native_function(module: ModuleType, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Any:
    """Function of a module whose one to three arguments are vectors of given sizes.

    It takes a batch as one leading axis of every argument, and `out=`.
    """
    maker = (_one, _two, _three)[len(sizes) - 1]
    return maker(module.one, np.empty, shape, _general(module, sizes, shape))


def _one(one: Any, empty: Any, shape: tuple[int, ...], general: Any) -> Callable[..., Array]:
    def function(a: Any, /, out: Array | None = None) -> Array:
        try:
            if a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, result)
                return result
        except _NOT_FAST:
            pass
        return general(out, a)

    return function


def _two(one: Any, empty: Any, shape: tuple[int, ...], general: Any) -> Callable[..., Array]:
    def function(a: Any, b: Any, /, out: Array | None = None) -> Array:
        try:
            if a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, b, result)
                return result
        except _NOT_FAST:
            pass
        return general(out, a, b)

    return function


def _three(one: Any, empty: Any, shape: tuple[int, ...], general: Any) -> Callable[..., Array]:
    def function(a: Any, b: Any, c: Any, /, out: Array | None = None) -> Array:
        try:
            if a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, b, c, result)
                return result
        except _NOT_FAST:
            pass
        return general(out, a, b, c)

    return function


def _general(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    def function(out: Array | None, *arguments: Any) -> Array:
        arrays = [np.ascontiguousarray(a, dtype=np.float64) for a in arguments]
        batch = arrays[0].shape[:-1]
        fits = [a.shape == (*batch, n) for a, n in zip(arrays, sizes, strict=True)]
        if len(batch) > 1 or not all(fits):
            given = ", ".join(str(a.shape) for a in arrays)
            single = ", ".join(f"({n},)" for n in sizes)
            many = ", ".join(f"(N, {n})" for n in sizes)
            raise ValueError(f"arguments must have shapes {single} or {many}; got {given}")
        expected = (*batch, *shape)
        if out is not None and (out.shape != expected or out.dtype != np.float64):
            given = f"got {out.dtype} of {out.shape}"
            raise ValueError(f"out must be float64 of shape {expected}, {given}")
        # Compiled signatures know one kind of array: read-only arguments are copied.
        arrays = [a if a.flags.writeable else a.copy() for a in arrays]
        result = np.empty(expected)
        if out is not None and out.flags.c_contiguous and out.flags.writeable:
            result = out
        (module.many if batch else module.one)(*arrays, result)
        if out is None or result is out:
            return result
        out[...] = result
        return out

    return function
