"""Cache of generated modules on disk: written and compiled by numba once, then only loaded.

The folder is the platform's cache folder for `armside` unless an argument names another. Where it
cannot be written the module is compiled in memory, which costs time in each process and no more.
"""

import hashlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import RLock
from types import ModuleType

_PACKAGE = Path(__file__).parent


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


def cached_module(
    name: str, key: str, source: Callable[[], str], folder: Path | str | None = None
) -> ModuleType:
    """The module with text `source()`, from the cache when `key` is there already."""
    digest = hashlib.sha256(_generator() + name.encode() + key.encode()).hexdigest()[:16]
    module_name = f"{name}_{digest}"
    path = Path(folder or cache_folder()) / f"{module_name}.py"
    with _LOADING:  # a second thread must not see a module that is half imported
        loaded = sys.modules.get(module_name)
        if loaded is not None and getattr(loaded, "__file__", None) == str(path):
            return loaded
        return _from_disk(module_name, path, source)


def _from_disk(module_name: str, path: Path, source: Callable[[], str]) -> ModuleType:
    try:
        if not path.exists():
            _write(path, source())
        return _import(module_name, path)
    except (OSError, RuntimeError):  # numba: RuntimeError when it finds no place for its cache
        return _in_memory(module_name, path.read_text() if path.exists() else source())


def _write(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    try:
        with os.fdopen(handle, "w") as file:
            file.write(text)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def _import(name: str, path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # numba finds a cached function's globals by module name
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _in_memory(name: str, text: str) -> ModuleType:
    module = ModuleType(name)
    exec(compile(text.replace("cache=True", "cache=False"), name, "exec"), module.__dict__)
    return module
