"""The parser of all commands, made of their functions."""

import re
from collections.abc import Callable, Mapping
from importlib.metadata import version
from inspect import getdoc
from typing import Any

from cyclopts import App, CycloptsError, Parameter
from cyclopts.exceptions import UnknownCommandError, UnusedCliTokensError

from .errors import InputError, checking_input, printable
from .options import read_value
from .registry import unknown

FOR_PROGRAMMERS = re.compile(r"(Raises|Returns|Yields)\b|(Args|Arguments|Parameters|Attributes):")
"""Begin of a paragraph of a docstring that help does not show."""

Load = Callable[[str], Callable[..., None]]
"""The function of a command."""


def make_app(commands: Mapping[str, str], load: Load, chosen: str = "") -> App:
    """The parser of all commands, of which only the chosen one is imported and knows its options.

    commands: line of help of each, by name. Help is the docstring of the command without the
    paragraphs for programmers.
    """
    app = App(
        name="armside",
        help="Iterative learning control of industrial robots, seen from the arm side.",
        version=lambda: f"armside {version('armside')}",
        default_parameter=Parameter(converter=read_value, negative=""),
        print_error=False,
        exit_on_error=False,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
    )
    for name, line in commands.items():
        if name == chosen:
            command = load(name)
            paragraphs = (getdoc(command) or line).split("\n\n")
            shown = "\n\n".join(text for text in paragraphs if not FOR_PROGRAMMERS.match(text))
            app.command(command, name=name, help=shown)
        else:
            app.command(App(name=name, help=line))
    return app


def parse(
    tokens: list[str], commands: Mapping[str, str], load: Load
) -> tuple[Callable[..., Any], Any]:
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
