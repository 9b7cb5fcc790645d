"""The parser of all commands, made of their functions."""

import re
from collections.abc import Callable, Collection, Mapping
from enum import Enum
from importlib.metadata import version
from inspect import getdoc
from typing import Any

from cyclopts import App, CycloptsError, Group, Parameter
from cyclopts.exceptions import UnknownCommandError, UnusedCliTokensError

from .errors import InputError, checking_input, printable, unknown
from .options import read_value

FOR_PROGRAMMERS = re.compile(r"(Raises|Returns|Yields)\b|(Args|Arguments|Parameters|Attributes):")
"""Begin of a paragraph of a docstring that help does not show."""

Commands = Mapping[str, tuple[str, str]]
"""Group and line of help of each command, by name."""
Load = Callable[[str], Callable[..., None]]
"""The function of a command."""


def make_app(commands: Commands, load: Load, chosen: str = "") -> App:
    """The parser of all commands, of which only the chosen one is imported and knows its options.

    Help is the docstring of the command without the paragraphs for programmers.
    """
    app = App(
        name="armside",
        help="Iterative learning control of industrial robots, seen from the arm side.",
        version=lambda: f"armside {version('armside')}",
        default_parameter=Parameter(converter=read_value, negative="", show_default=shown),
        print_error=False,
        exit_on_error=False,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
    )
    order = list(dict.fromkeys(group for group, _ in commands.values()))
    groups = {name: Group(name, sort_key=i) for i, name in enumerate(order)}
    for name, (group, line) in commands.items():
        if name == chosen:
            command = load(name)
            paragraphs = (getdoc(command) or line).split("\n\n")
            text = "\n\n".join(text for text in paragraphs if not FOR_PROGRAMMERS.match(text))
            app.command(command, name=name, help=text, group=groups[group])
        else:
            app.command(App(name=name, help=line, group=groups[group]))
    return app


def shown(default: Any) -> str | None:
    """A default as a person would type it; None for nothing, a flag that is off among it."""
    if default is None or default is False or default == "":
        return None
    if isinstance(default, Enum):
        return str(default.value)
    if isinstance(default, Collection) and not isinstance(default, str):
        return " ".join(shown(item) or "" for item in default) or None
    return f"{default:g}" if isinstance(default, float) else str(default)


def parse(tokens: list[str], commands: Commands, load: Load) -> tuple[Callable[..., Any], Any]:
    """The function of a command line, and its arguments. Raises InputError for bad input."""
    app = make_app(commands, load, chosen=tokens[0] if tokens else "")
    with checking_input():
        try:
            command, bound, _ = app.parse_args(tokens)
        except UnknownCommandError:
            raise unknown("experiment", tokens[0], commands) from None
        except UnusedCliTokensError as error:
            words = " ".join(error.unused_tokens or ())
            raise InputError(f"Unexpected {words!r}; options are written --name value") from None
        except CycloptsError as error:
            raise InputError(printable(str(error))) from error
    return command, bound
