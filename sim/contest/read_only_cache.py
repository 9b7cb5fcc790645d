"""Numba takes what the machine has compiled, and writes nothing: for processes that may not write.

To be imported before anything is compiled. Without it each entry compiles for half a minute.
"""

from typing import Any

from numba.core import caching


def _nothing(*_: Any) -> None:
    """In place of a check that the cache can be written to, and of writing."""


caching._CacheLocator.ensure_cache_path = _nothing
caching.Cache.save_overload = _nothing
