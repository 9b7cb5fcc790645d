"""Generated functions of arrays, in a cache on disk: compiled by numba once, then only loaded.

The folder is the platform's cache folder for `armside` unless an argument names another. Where it
cannot be written the module is compiled in memory, which costs time in each process and no more.
The same holds for a folder or module that somebody else may have written: it is not executed. A
module carries the digest of its text; a damaged one is generated again. Both are logged.

A native function has two paths. The fast one is the cost of a call in a control loop: no
conversion, no copy; types are compared and one attribute is read. Arguments that it cannot take go
to the general path, which converts, copies, handles batches, and says which shapes are allowed. NaN
and infinities are not refused: each element of the result that depends on one is NaN.
"""

import hashlib
import logging
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.arrays import Array, check_out, real_array

if TYPE_CHECKING:
    from .equations.program import StraightLineProgram

_PACKAGE = Path(__file__).parent
_LOG = logging.getLogger(__name__)
_DIGEST = "# sha256 of the text above: "


def cache_folder() -> Path:
    """Folder of generated code by default."""
    from platformdirs import user_cache_path

    return user_cache_path("armside", appauthor=False) / "kinematics"


@cache
def _generator() -> bytes:
    """Digest of this package: a changed generator must not find old files."""
    digest = hashlib.sha256()
    for file in sorted(_PACKAGE.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.digest()


_LOADING = RLock()
_LOADED: dict[Path, ModuleType] = {}


def cached_module(
    name: str, key: str, source: Callable[[], str], folder: Path | str | None = None
) -> ModuleType:
    """The module with text `source()`, from the cache when `key` is there already."""
    digest = hashlib.sha256(_generator() + name.encode() + key.encode()).hexdigest()[:16]
    module_name = f"{name}_{digest}"
    path = Path(folder or cache_folder()) / f"{module_name}.py"
    with _LOADING:  # a second thread must not see a module that is half executed
        if path not in _LOADED:
            _LOADED[path] = _load(module_name, path, source)
        return _LOADED[path]


def loaded_files() -> list[Path]:
    """Files of the modules that this process has loaded, with their machine code."""
    return [file for path in _LOADED for file in (path, *_compiled(path)) if file.exists()]


def _load(name: str, path: Path, source: Callable[[], str]) -> ModuleType:
    text = None
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if (foreign := _foreign(path)) is not None:
            _report_foreign(foreign)
            return _in_memory(name, source())
        text = _read(path)
        if text is None:
            _LOG.info("compiling %s, once on this machine", name.rpartition("_")[0])
            text = source()
            _write(path, text)
        return _execute_or_repair(name, path, text)
    except (OSError, RuntimeError):  # numba: RuntimeError when it finds no place for its cache
        return _in_memory(name, text or source())


def _foreign(path: Path) -> Path | None:
    """The first of a module's folders and files that somebody other than us and root may write."""
    for place in (path.parent, path, path.parent / "__pycache__", *_compiled(path)):
        try:
            status = place.stat()
        except FileNotFoundError:
            continue
        if status.st_uid not in (os.geteuid(), 0) or status.st_mode & 0o022:
            return place
    return None


@cache
def _report_foreign(place: Path) -> None:
    remedy = "others may write it; remove it, or make it yours alone with chown and chmod go-w"
    _LOG.warning("code in the cache is not used and compiled in memory: %s: %s", place, remedy)


def _compiled(path: Path) -> list[Path]:
    """Files of numba beside a module: index and machine code of each function."""
    return list((path.parent / "__pycache__").glob(f"{path.stem}.*.nb[ci]"))


def _read(path: Path) -> str | None:
    """Text of a module; None if it is not there or damaged."""
    try:
        text, found, digest = path.read_text(encoding="utf-8").rpartition(_DIGEST)
    except FileNotFoundError:
        return None
    except UnicodeDecodeError:
        text, found, digest = "", "", ""
    if found and digest.strip() == hashlib.sha256(text.encode()).hexdigest():
        return text
    _LOG.warning("%s was damaged and is generated again", path)
    return None


def _write(path: Path, text: str) -> None:
    """Write a module whole or not at all."""
    (path.parent / "__pycache__").mkdir(mode=0o700, exist_ok=True)  # numba would leave it to umask
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(f"{text}{_DIGEST}{hashlib.sha256(text.encode()).hexdigest()}\n")
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def _execute_or_repair(name: str, path: Path, text: str) -> ModuleType:
    """The module; damaged machine code beside it is removed, and compiled again."""
    try:
        return _execute(name, path, text)
    except Exception as error:
        compiled = _compiled(path)
        if not compiled or "cannot cache" in str(error):  # numba: the folder can only be read
            raise
        for file in compiled:
            file.unlink(missing_ok=True)
        _LOG.warning("machine code of %s was damaged and is compiled again: %r", path, error)
        return _execute(name, path, text)


def _execute(name: str, path: Path, text: str) -> ModuleType:
    """The text as a module of that file: exactly what was read, no bytecode from elsewhere."""
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module  # numba finds a cached function's globals by module name
    try:
        exec(compile(text, str(path), "exec"), module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _in_memory(name: str, text: str) -> ModuleType:
    module = ModuleType(name)
    exec(compile(text.replace("cache=True", "cache=False"), name, "exec"), module.__dict__)
    return module


_FAST = """
def function({arguments}, /, out=None):
    try:
        if {types} is array and a.ndim == 1:
            result = empty(shape) if out is None else out
            one({arguments}, result)
            return result
    except (AttributeError, TypeError, ValueError):
        pass
    return general(out, {arguments})
"""


def native_function(
    name: str,
    key: str,
    program: "Callable[[], StraightLineProgram]",
    sizes: tuple[int, ...],
    shape: tuple[int, ...],
    folder: Path | str | None = None,
) -> Any:
    """Compiled function of a program whose one to four arguments are vectors of given sizes.

    The program is built only when `key` is not in the cache yet. The function takes a batch as one
    leading axis of every argument, and `out=`, which may overlap the arguments: a single call reads
    all of them before it writes, and a batch goes by a copy.
    """

    def source() -> str:
        from .codegen import numba_module

        return numba_module(program())

    module, names = cached_module(name, key, source, folder), "abcd"[: len(sizes)]
    types = " is ".join(f"type({argument})" for argument in names)
    scope = {"one": module.one, "empty": np.empty, "array": np.ndarray, "shape": shape}
    scope["general"] = _general(module, sizes, shape)
    exec(_FAST.format(arguments=", ".join(names), types=types), scope)
    return scope["function"]


def _general(module: Any, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Callable[..., Array]:
    def function(out: Array | None, *arguments: Any) -> Array:
        arrays = [np.ascontiguousarray(real_array("arguments", a)) for a in arguments]
        batch = arrays[0].shape[:-1]  # () or (N,)
        if len(batch) > 1 or [a.shape for a in arrays] != [(*batch, n) for n in sizes]:
            given = ", ".join(str(a.shape) for a in arrays)
            single = ", ".join(f"({n},)" for n in sizes)
            many = ", ".join(f"(N, {n})" for n in sizes)
            raise ValueError(f"arguments must have shapes {single} or {many}; got {given}")
        expected = (*batch, *shape)
        if out is not None:
            check_out(out, expected)
        # Compiled signatures know one kind of array: read-only arguments are copied.
        arrays = [a if a.flags.writeable else a.copy() for a in arrays]
        result = np.empty(expected)
        if out is not None and out.flags.c_contiguous and out.flags.writeable:
            # Rows may be written to `out` before all rows of the arguments are read.
            overlaps = any(np.may_share_memory(out, a) for a in arrays)
            result = result if overlaps else out
        (module.many if batch else module.one)(*arrays, result)
        if out is None or result is out:
            return result
        out[...] = result
        return out

    return function
