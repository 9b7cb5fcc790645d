"""Options of every command, and the reading of option values.

A command's own options are a frozen dataclass decorated with `@options`; attribute docstrings are
the help texts. A configuration checks its own ranges in `__post_init__` with ValueError.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from cyclopts import Group, Parameter, Token, convert
from cyclopts.validators import Number

from armside.sim.records.files import check_file, check_file_to_write
from armside.sim.records.run_folder import check_destination, check_shared_folder, check_writable

from .help import COMMON

options = Parameter(name="*")
"""Decorator: the fields of a dataclass become options of the command itself."""
SEVERAL = Parameter(consume_multiple=True)
SOME = Parameter(consume_multiple=True, show_default=False)
"""Of an option with several values; of one whose default is none, or follows from others."""


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from _leaves(item)
    else:
        yield value


def read_value(type_: Any, tokens: Sequence[Token]) -> Any:
    """Convert the words of one option; refuse floats that are not finite, rounded integers, and
    an empty path, which would be the working folder."""
    value = convert(type_, tokens)
    for leaf, token in zip(_leaves(value), tokens, strict=False):
        if isinstance(leaf, float) and not math.isfinite(leaf):
            raise ValueError(f"must be a finite number, got {token.value}")
        if type(leaf) is int and "." in token.value and float(token.value) != leaf:
            raise ValueError(f"must be a whole number, got {token.value}")
        if isinstance(leaf, Path) and not token.value:
            raise ValueError("must name a file or a folder, got an empty text")
    return value + 0.0 if isinstance(value, float) else value  # -0.0 is 0.0


class Limits(NamedTuple):
    """Smallest and largest value of an option, and its unit."""

    low: float = -math.inf
    high: float = math.inf
    unit: str = ""
    above: bool = False
    """The smallest value itself is not allowed."""
    below: bool = False
    """The largest value itself is not allowed."""

    def __str__(self) -> str:
        if math.isinf(self.high):
            text = f"{'>' if self.above else '>='} {self.low:g}"
        elif math.isinf(self.low):
            text = f"at most {self.high:g}"
        elif self.above or self.below:
            ends = "(" if self.above else "[", ")" if self.below else "]"
            text = f"in {ends[0]}{self.low:g}, {self.high:g}{ends[1]}"
        else:
            text = f"{self.low:g} to {self.high:g}"
        return f"{text} {self.unit}".rstrip()

    def check(self, name: str, given: Any) -> None:
        """Raise ValueError for a number, or one of a tuple, outside of the limits."""
        for value in given if isinstance(given, tuple) else (given,):
            within = value is None or self.low <= value <= self.high
            if (
                not within
                or (self.above and value == self.low)
                or (self.below and value == self.high)
            ):
                raise ValueError(f"{name.replace('_', '-')} must be {self}, got {value:g}")


def check_limits(cfg: Any, limits: Mapping[str, Limits]) -> None:
    """Raise ValueError for an option, by its name, that is outside of its limits."""
    for name, allowed in limits.items():
        allowed.check(name, getattr(cfg, name))


PERCENT = Limits(0.0, 100.0, "%", below=True)
SEED = Limits(0, 2**63 - 1)
"""Datasets and other programs hold a seed in 64 bits."""


def seed_range(first: int, n: int) -> range:
    """n seeds from the first on. Raises ValueError for one that is too large."""
    SEED.check("seed", first + n - 1)
    return range(first, first + n)


def path_checked(*checks: Callable[[Path], object]) -> Callable[[Any, Any], None]:
    """Validator of an option that may be a path, by functions that raise for one."""

    def check_each(_type: Any, given: Any) -> None:
        if isinstance(given, Path):
            for check in checks:
                check(given)

    return check_each


check_read = path_checked(check_file)
"""Validator of an option that may name a file to be parsed."""
Count = Annotated[int, Parameter(validator=Number(gte=1))]
"""Type of an option that is a number of things, of which there is at least one."""
FileToRead = Annotated[Path | None, Parameter(validator=check_read)]
"""Type of an option that names a file to be parsed: it must be there, and of a sane size."""
Folder = Annotated[Path, Parameter(validator=path_checked(check_shared_folder))]
"""Type of an option that names a folder, new or not, that files are added to."""
FileToWrite = Annotated[Path | None, Parameter(validator=path_checked(check_file_to_write))]
"""Type of an option that names a file to write: its folder must be there and writable."""


_OUT = Parameter(validator=path_checked(check_destination, check_writable))


@Parameter(name="*", group=Group(COMMON, sort_key=9))
@dataclass(frozen=True, kw_only=True)
class Common:
    """Options of every command."""

    seed: int = 0
    """Seed of every random draw, >= 0: same seed, same bits."""
    out: Annotated[Path | None, _OUT] = None
    """Folder for the results, new or empty [default of a run: a new one under runs/]."""
    json: bool = False
    """Print the summary as JSON, and nothing else, on standard output."""
    quiet: bool = False
    """Print neither progress nor tables."""
    debug: bool = False
    """Show the traceback of a failure."""

    def __post_init__(self) -> None:
        SEED.check("seed", self.seed)
