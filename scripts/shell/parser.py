"""The parser of all commands, made of their functions."""

import re
from collections.abc import Callable, Collection, Mapping
from enum import Enum
from importlib.metadata import version
from inspect import getdoc
from itertools import pairwise
from typing import Any

from cyclopts import App, CycloptsError, Parameter
from cyclopts.exceptions import UnusedCliTokensError

from .errors import InputError, checking_input, printable, unknown
from .help import BRIEF, WHOLE, BriefHelp
from .options import read_value

FOR_PROGRAMMERS = re.compile(r"(Raises|Returns|Yields)\b|(Args|Arguments|Parameters|Attributes):")
"""Begin of a paragraph of a docstring that help does not show."""

Commands = Mapping[str, tuple[str, str]]
"""Group and line of help of each command, by name."""
Load = Callable[[str], Callable[..., None]]
"""The function of a command."""


def make_app(commands: Commands, load: Load, chosen: str = "", *, whole: bool = False) -> App:
    """The parser of one command, which is imported; without one, of `--version`. Help is the
    docstring of the command without the paragraphs for programmers. whole: with the whole text of
    each option."""
    more = f"armside {chosen} {WHOLE} has the whole text of each option."
    app = App(
        name="armside",
        version=lambda: f"armside {version('armside')}",
        default_parameter=Parameter(converter=read_value, negative="", show_default=shown),
        help_flags=(*BRIEF, WHOLE),
        help_format="markdown" if whole else "plaintext",
        help_formatter=None if whole else BriefHelp(),
        help_epilogue=None if whole else more,
        print_error=False,
        exit_on_error=False,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
    )
    if chosen in commands:
        command = load(chosen)
        paragraphs = (getdoc(command) or commands[chosen][1]).split("\n\n")
        text = "\n\n".join(text for text in paragraphs if not FOR_PROGRAMMERS.match(text))
        app.command(command, name=chosen, help=text)
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
    chosen = tokens[0] if tokens else ""
    if chosen not in (*commands, "--version"):
        raise unknown("experiment", chosen, commands)
    for before, word in pairwise(tokens):
        if not word or (word.startswith("--") and word.endswith("=")):
            raise InputError(f"{word or before} has an empty value")
    app = make_app(commands, load, chosen, whole=WHOLE in tokens)
    with checking_input():
        try:
            command, bound, _ = app.parse_args(tokens)
        except UnusedCliTokensError as error:
            words = " ".join(error.unused_tokens or ())
            raise InputError(f"Unexpected {words!r}; options are written --name value") from None
        except CycloptsError as error:
            raise InputError(printable(str(error))) from error
    return command, bound
