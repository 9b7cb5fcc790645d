"""Options of the commands, from their signatures: a new option is tried without being named."""

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from inspect import Parameter as Argument
from inspect import signature
from types import NoneType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from cyclopts import Parameter

from ..shell.options import FileToRead, FileToWrite, Folder

TRACEBACK = "debug"
"""The option that asks for a traceback."""


class Option(NamedTuple):
    """One option or positional argument."""

    name: str
    """As it is written, such as `--radius`; empty for a positional argument."""
    type: Any
    """Of one word: float, int, bool, str, Path, a Literal, or a union of them."""
    words: int | None
    """Number of words that it takes; None for any number."""
    role: str
    """Of a path: read, write, folder, or empty."""


def options_of(command: Callable[..., None]) -> list[Option]:
    """Options and positional arguments of a command."""
    hints = get_type_hints(command, include_extras=True)
    found: list[Option] = []
    for parameter in signature(command).parameters.values():
        hint = hints[parameter.name]
        if is_dataclass(hint):
            own = get_type_hints(hint, include_extras=True)
            names = [field.name for field in fields(hint) if field.name != TRACEBACK]
            found += [_option(_written(name, own[name]), own[name]) for name in names]
        else:
            several = parameter.kind is Argument.VAR_POSITIONAL
            found.append(_option("", hint)._replace(words=None if several else 1))
    return found


def _written(field: str, hint: Any) -> str:
    """An option as it is written: by the name of its annotation, or else of its field."""
    stated = [part.name for part in get_args(hint) if isinstance(part, Parameter)]
    given = [names[0] for names in stated if isinstance(names, tuple) and names]
    return given[0] if given else f"--{field.replace('_', '-')}"


def _option(name: str, hint: Any) -> Option:
    roles = {FileToRead: "read", FileToWrite: "write", Folder: "folder"}
    parts = [hint, *(part for part in get_args(hint) if part in roles)]
    role = next((roles[part] for part in parts if part in roles), "")
    hint = _given(hint)
    inner = get_args(hint)
    if get_origin(hint) is not tuple:
        return Option(name, hint, 1, role)
    words = None if inner[-1] is Ellipsis else len(inner)
    return Option(name, _given(inner[0]), words, role)


def _given(hint: Any) -> Any:
    """The type without annotations, and without None."""
    while get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    if NoneType not in get_args(hint):
        return hint
    first, *others = [part for part in get_args(hint) if part is not NoneType]
    return Union[first, *others] if others else _given(first)
