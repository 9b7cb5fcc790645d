"""Names that a registry has, and the error for one that it does not have."""

import difflib
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

from .errors import InputError


def load(path: str) -> Callable[..., Any]:
    """The function at `module:function`."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


def unknown(kind: str, given: str, names: Iterable[str]) -> InputError:
    """The error for a name that does not exist: what does, and what is near."""
    names = list(names)
    near = difflib.get_close_matches(given, names, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    return InputError(f"Unknown {kind} {given!r}.{hint} It can be: {', '.join(names)}")
