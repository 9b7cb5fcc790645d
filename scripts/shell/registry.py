"""The error for a name that a registry does not have."""

import difflib
from collections.abc import Iterable

from .errors import InputError


def unknown(kind: str, given: str, names: Iterable[str]) -> InputError:
    """The error for a name that does not exist: what does, and what is near."""
    names = list(names)
    near = difflib.get_close_matches(given, names, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    return InputError(f"Unknown {kind} {given!r}.{hint} It can be: {', '.join(names)}")
