"""Shapely, of the extra `parts`: imported where it is first used, so that help needs no extra."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import shapely as shapely
else:

    class _Shapely:
        def __getattr__(self, name: str) -> Any:
            return getattr(import_module("shapely"), name)

    shapely = _Shapely()
