"""Help texts: the overview of all commands, and the options of a command in about a line each.

`armside NAME --help` shows the first clause of each option's text, and names alone of options that
many commands share; `armside NAME --help-all` shows the whole text.
"""

import re
from collections.abc import Mapping
from textwrap import fill
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel

BRIEF, WHOLE = ("--help", "-h"), "--help-all"
ABOUT = "Iterative learning control of industrial robots, seen from the arm side."
COMMON, BAG = "Options of every command", "Recording in a ROS bag"
NAMES_ONLY = frozenset((COMMON, BAG))
"""Groups of options that many commands share: brief help has their names alone."""
WIDTH, COLUMN = 80, 22
"""Characters of a line of brief help, and of its widest column of names."""
VALUES = {"FLOAT": "X", "INT": "N", "STR": "NAME", "CHOICE": ""}
"""Words of brief help for the types of values; choices are listed instead."""
CLAUSE = re.compile(r"(?:\[[^\]]*\]|\([^)]*\)|[.;](?=\S)|[^.;\[(])+")
"""First clause of a text. Brackets are whole."""


def overview(commands: Mapping[str, tuple[str, str]]) -> str:
    """Text of `armside --help`. commands: group and line of each command, by name."""
    column = max(map(len, commands))
    lines = ["Usage: armside COMMAND [OPTIONS]", "", ABOUT]
    for group in dict.fromkeys(group for group, _ in commands.values()):
        lines += ["", f"{group}:"]
        own = ((name, line) for name, (of, line) in commands.items() if of == group)
        lines += [f"  {name:{column}}  {line}" for name, line in own]
    more = f"armside COMMAND {BRIEF[0]} lists its options, {WHOLE} with their whole text."
    return "\n".join([*lines, "", more])


class BriefHelp:
    """Formatter of cyclopts for a command's help in plain lines."""

    def render_usage(self, console: Any, options: Any, usage: Any) -> None:
        """Print the line of usage."""
        _print(console, f"Usage: {_short(_plain(usage))}\n")

    def render_description(self, console: Any, options: Any, description: Any) -> None:
        """Print the paragraphs of a command's docstring."""
        paragraphs = _plain(description).split("\n\n")
        _print(console, "\n\n".join(_filled(text.replace("`", ""), "") for text in paragraphs))

    def __call__(self, console: Any, options: Any, panel: "HelpPanel") -> None:
        """Print one group of options."""
        title = _plain(panel.title)
        if not panel.entries:
            return
        if title not in NAMES_ONLY:
            column = min(COLUMN, max(len(_label(entry)) for entry in panel.entries))
            lines = [_row(entry, column) for entry in panel.entries]
            _print(console, "\n".join(["", f"{title}:", *lines]))
            return
        names = " ".join(entry.positive_names[0] for entry in panel.entries)
        _print(console, "\n" + _filled(f"{title}: {names}", "  "))


def _row(entry: "HelpEntry", column: int) -> str:
    parts = [first_clause(_plain(entry.description))]
    if entry.choices:
        parts = [": ".join(part for part in (*parts, ", ".join(entry.choices)) if part)]
    if entry.default is not None:
        parts.append(f"[default: {entry.default}]")
    if entry.required:
        parts.append("[required]")
    text = " ".join(part for part in parts if part)
    start, indent = f"  {_label(entry):{column}}  ", " " * (column + 4)
    return _filled(start + text, indent)


def _label(entry: "HelpEntry") -> str:
    if entry.positional_label:
        return entry.positional_label
    return f"{entry.positive_names[0]} {_short(entry.metavar or '')}".rstrip()


def _short(text: str) -> str:
    return re.sub(r"\b(?:" + "|".join(VALUES) + r")\b", lambda found: VALUES[found[0]], text).strip(
        "|"
    )


def first_clause(text: str) -> str:
    """A text up to its first full stop or semicolon, on one line, without marks of code."""
    found = CLAUSE.match(" ".join(text.replace("`", "").split()))
    return found[0].strip() if found else ""


def _plain(text: Any) -> str:
    text = getattr(text, "primary_renderable", text)
    return str(getattr(text, "plain", "" if text is None else text)).strip()


def _filled(text: str, indent: str) -> str:
    """Text in lines, those after the first indented, and options left whole."""
    return fill(text, WIDTH, subsequent_indent=indent, break_on_hyphens=False)


def _print(console: Any, text: str) -> None:
    console.print(text, markup=False, highlight=False, soft_wrap=True)
