"""Options of every command, and the reading of option values.

A command's own options are a frozen dataclass decorated with `@options`; attribute docstrings are
the help texts. A configuration checks its own ranges in `__post_init__` with ValueError.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter, Token, convert

from armside.sim.records.run_folder import check_destination

options = Parameter(name="*")
"""Decorator: the fields of a dataclass become options of the command itself."""


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from _leaves(item)
    else:
        yield value


def read_value(type_: Any, tokens: Sequence[Token]) -> Any:
    """Convert the words of one option; refuse floats that are not finite and rounded integers."""
    value = convert(type_, tokens)
    for leaf, token in zip(_leaves(value), tokens, strict=False):
        if isinstance(leaf, float) and not math.isfinite(leaf):
            raise ValueError(f"must be a finite number, got {token.value}")
        if type(leaf) is int and "." in token.value and float(token.value) != leaf:
            raise ValueError(f"must be a whole number, got {token.value}")
    return value


def _check_out(_type: Any, out: Path | None) -> None:
    if out is not None:
        check_destination(out)


@Parameter(name="*", group=Group("Options of every command", sort_key=9))
@dataclass(frozen=True, kw_only=True)
class Common:
    """Options of every command."""

    seed: int = 0
    """Seed of every random draw, >= 0: same seed, same bits."""
    out: Annotated[Path | None, Parameter(validator=_check_out)] = None
    """Folder for the results, new or empty [default of a run: a new one under runs/]."""
    json: bool = False
    """Print the summary as JSON, and nothing else, on standard output."""
    quiet: bool = False
    """Print neither progress nor tables."""
    debug: bool = False
    """Show the traceback of a failure."""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ValueError(f"seed must be >= 0, got {self.seed}")
