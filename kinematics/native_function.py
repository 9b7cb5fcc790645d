"""Straight-line programs as native functions of arrays, generated on first use and kept on disk.

A function has two paths. The fast one is the cost of a call in a control loop: no conversion, no
copy; types are compared and one attribute is read. Arguments that it cannot take go to the general
path, which converts, copies, handles batches, and says which shapes are allowed. NaN and infinities
are not refused: each element of the result that depends on one is NaN.
"""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from armside.arrays import Array

from .arguments import check_out, real_array
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

    It takes a batch as one leading axis of every argument, and `out=`, which may overlap the
    arguments: a single call reads all of them before it writes, and a batch goes by a copy.
    """
    maker = (_one, _two, _three)[len(sizes) - 1]
    return maker(module.one, np.empty, shape, _general(module, sizes, shape))


def _one(one: Any, empty: Any, shape: tuple[int, ...], general: Any) -> Callable[..., Array]:
    array = np.ndarray

    def function(a: Any, /, out: Array | None = None) -> Array:
        try:
            if type(a) is array and a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, result)
                return result
        except _NOT_FAST:
            pass
        return general(out, a)

    return function


def _two(one: Any, empty: Any, shape: tuple[int, ...], general: Any) -> Callable[..., Array]:
    array = np.ndarray

    def function(a: Any, b: Any, /, out: Array | None = None) -> Array:
        try:
            if type(a) is type(b) is array and a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, b, result)
                return result
        except _NOT_FAST:
            pass
        return general(out, a, b)

    return function


def _three(one: Any, empty: Any, shape: tuple[int, ...], general: Any) -> Callable[..., Array]:
    array = np.ndarray

    def function(a: Any, b: Any, c: Any, /, out: Array | None = None) -> Array:
        try:
            if type(a) is type(b) is type(c) is array and a.ndim == 1:
                result = empty(shape) if out is None else out
                one(a, b, c, result)
                return result
        except _NOT_FAST:
            pass
        return general(out, a, b, c)

    return function


def _general(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    def function(out: Array | None, *arguments: Any) -> Array:
        arrays = [np.ascontiguousarray(real_array("arguments", a)) for a in arguments]
        batch = _common_batch(arrays, sizes)
        expected = (*batch, *shape)
        if out is not None:
            check_out(out, expected)
        # Compiled signatures know one kind of array: read-only arguments are copied.
        arrays = [a if a.flags.writeable else a.copy() for a in arrays]
        result = out if _can_be_filled(out, arrays) else np.empty(expected)
        (module.many if batch else module.one)(*arrays, result)
        if out is None or result is out:
            return result
        out[...] = result
        return out

    return function


def _common_batch(arrays: list[Array], sizes: tuple[int, ...]) -> tuple[int, ...]:
    """The leading axis of all arguments: () or (N,)."""
    batch = arrays[0].shape[:-1]
    fits = [a.shape == (*batch, n) for a, n in zip(arrays, sizes, strict=True)]
    if len(batch) > 1 or not all(fits):
        given = ", ".join(str(a.shape) for a in arrays)
        single = ", ".join(f"({n},)" for n in sizes)
        many = ", ".join(f"(N, {n})" for n in sizes)
        raise ValueError(f"arguments must have shapes {single} or {many}; got {given}")
    return batch


def _can_be_filled(out: Array | None, arrays: list[Array]) -> TypeGuard[Array]:
    """True if rows may be written to `out` before all rows of the arguments are read."""
    if out is None or not (out.flags.c_contiguous and out.flags.writeable):
        return False
    return not any(np.may_share_memory(out, a) for a in arrays)
