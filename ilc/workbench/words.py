"""Words that name a plant or a law: `name`, `name:key=value,key=value` or `file.py:Name:...`."""

import difflib
import inspect
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

OWN = re.compile(r"(?P<file>.+\.py):(?P<name>[A-Za-z_]\w*)(?::(?P<rest>.*))?", re.DOTALL)
SEPARATOR = re.compile(r",|:(?=\s*[A-Za-z_]\w*\s*=)")
"""A comma, or a colon before the next key=value."""
WORD = re.compile(r"(?P<name>[^:]*)(?::(?P<rest>.*))?", re.DOTALL)


@dataclass(frozen=True)
class Words:
    """A name with parameters; `file` is that of a Python file, or empty."""

    text: str
    name: str
    file: str = ""
    parameters: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: str) -> "Words":
        """Raises ValueError for parameters that are not key=value."""
        own = OWN.fullmatch(text)
        found = own or WORD.fullmatch(text)
        assert found is not None, text  # WORD takes every text
        parameters: dict[str, str] = {}
        for part in filter(None, SEPARATOR.split(found["rest"] or "")):
            key, equals, value = (each.strip() for each in part.partition("="))
            if not (key.isidentifier() and equals and value):
                raise ValueError(f"parameters are written key=value,key=value, got {part!r}")
            if key in parameters:
                raise ValueError(f"{key} is given twice in {text!r}")
            parameters[key] = value
        return cls(text, found["name"], found["file"] if own else "", parameters)


def number(text: str, name: str, whole: bool = False) -> float | int:
    """A finite number. Raises ValueError."""
    try:
        value = int(text) if whole else float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{name} must be a {'whole' if whole else 'finite'} number, got {text!r}")
    return value


def converted(parameters: Mapping[str, str], accepts: Callable[..., Any]) -> dict[str, Any]:
    """Values of the keyword-only parameters of a function, of their annotated types.

    int, float and str, also `| None`; tuple[float, ...] is written 0.5/0.25. Raises ValueError for
    a parameter that the function does not have.
    """
    known = {
        name: parameter.annotation
        for name, parameter in inspect.signature(accepts).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    }
    return {key: _value(key, text, known) for key, text in parameters.items()}


def _value(key: str, text: str, known: Mapping[str, Any]) -> Any:
    if key not in known:
        raise ValueError(unknown_name("parameter", key, known))
    if known[key] in (str, str | None):
        return text
    if known[key] in (int, int | None):
        return number(text, key, whole=True)
    if known[key] == tuple[float, ...]:
        return tuple(float(number(part, key)) for part in text.split("/"))
    return float(number(text, key))


def guessed(parameters: Mapping[str, str]) -> dict[str, Any]:
    """Values of parameters without annotation: whole numbers, numbers, or text."""
    values: dict[str, Any] = {}
    for key, text in parameters.items():
        try:
            values[key] = int(text)
        except ValueError:
            try:
                values[key] = number(text, key)
            except ValueError:
                values[key] = text
    return values


def unknown_name(kind: str, given: str, names: Iterable[str]) -> str:
    """The message for a name that does not exist: what does, and what is near."""
    names = list(names)
    near = difflib.get_close_matches(given, names, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    there = f"It can be: {', '.join(names)}" if names else "There are none"
    return f"Unknown {kind} {given!r}.{hint} {there}"
