"""Numba takes what the machine has compiled, and writes nothing: for processes that may not write.

To be imported before anything is compiled. Without it each entry compiles for half a minute.
"""

from typing import Any

from numba.core import caching

_nothing: Any = lambda *_: None  # noqa: E731 - in place of two methods
caching._CacheLocator.ensure_cache_path = _nothing
caching.Cache.save_overload = _nothing
