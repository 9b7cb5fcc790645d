"""The grid of `armside sweep`: axes over the options of `armside laser`, and its points.

An axis is written `option=value,value`; whole numbers also `first:last+1`, values of six motors
`0.9/0.9/0.8/0.8/0.8/0.8`, and none of several `without=,ripple`.
"""

import re
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from cyclopts import CycloptsError, Token

from ..commands.laser import LaserCfg, task
from ..shell.errors import InputError, one_line
from ..shell.options import Common, read_value
from ..shell.registry import unknown
from .resolved import Content, content_of, identity, key_of

SEED = "seed"
TYPES: Mapping[str, Any] = get_type_hints(LaserCfg) | {SEED: int}
"""Of the options that can be axes."""
Item = tuple[str, Hashable]
"""An option and a value of it."""
_RANGE = re.compile(r"(-?\d+):(-?\d+)")


@dataclass(frozen=True)
class Point:
    """One configuration of a grid."""

    key: str
    """Hash of the whole configuration: all that its options come to, files and seed included."""
    options: Mapping[str, Any]
    """Options of `armside laser`, typed; those left out have their defaults."""
    seed: int


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some options."""

    axes: Mapping[str, Sequence[Any]]

    def __len__(self) -> int:
        """Number of combinations; fewer points where several come to the same configuration."""
        n = 1
        for values in self.axes.values():
            n *= len(values)
        return n

    def __iter__(self) -> Iterator[Point]:
        """The points, the last axis fastest, each configuration once."""
        content, seen = cache(content_of), set[str]()
        for options in self.combinations():
            seed = options.pop(SEED)
            key = key_of(options, seed, content)
            if key not in seen:
                seen.add(key)
                yield Point(key=key, options=options, seed=seed)

    def combinations(self) -> Iterator[dict[str, Any]]:
        """Every combination of the values, by name, the last axis fastest."""
        for values in product(*self.axes.values()):
            yield dict(zip(self.axes, values, strict=True))


def parse(words: Sequence[str], seed: int) -> Grid:
    """A grid from the words of a command line; `seed` where no axis gives any.

    Raises:
        InputError: an axis that is no option of `armside laser`, is there twice or has a value
            that the option does not take, alone or beside any of the other axes' values.
    """
    axes: dict[str, Sequence[Any]] = {}
    written: dict[Item, str] = {}
    for word in words:
        name, equals, text = word.partition("=")
        if not equals:
            raise InputError(f"a grid is written option=value,value; got {word!r}")
        name = name.lstrip("-").replace("-", "_")
        if name not in TYPES:
            raise unknown("option of laser", name, TYPES)
        if name in axes:
            raise InputError(f"{name} is given twice")
        values = _values(name, text)
        written |= {(name, value): f"{name}={part}" for value, part in values.items()}
        axes[name] = list(values)
    if not axes:
        raise InputError("give at least one axis, such as gamma=0.5,0.9 or pose=p1,p2,p3")
    _refuse_impossible(Grid({name: axes[name] for name in axes if name != SEED}), written)
    return Grid(axes | {SEED: axes.get(SEED, (seed,))})


def configuration(point: Point) -> LaserCfg:
    """The checked options of a point. Raises ValueError where they do not go together."""
    return LaserCfg(**point.options)


def _values(name: str, text: str) -> dict[Any, str]:
    """The values of an axis, each with how it was written."""
    hint = _when_given(TYPES[name])
    numbers = {int, float} & {hint, *get_args(hint)}
    spanned = _RANGE.fullmatch(text) if numbers else None
    words = (
        [str(i) for i in range(int(spanned[1]), int(spanned[2]))] if spanned else text.split(",")
    )
    values: dict[Any, str] = {}
    for word in map(str.strip, words):
        value = _value(name, word)
        if value in values:
            raise InputError(f"{name}={text} has a value twice")
        values[value] = word
    if not values:
        raise InputError(f"{name}={text} has no values")
    return values


def _value(name: str, word: str) -> Any:
    """One value, read as the command line of `armside laser` does."""
    several = get_origin(_when_given(TYPES[name])) is tuple
    if not word:
        if several:
            return ()
        raise InputError(f"{name} has an empty value")
    option = f"--{name.replace('_', '-')}"
    parts = word.split("/") if several else [word]
    try:
        value = read_value(TYPES[name], [Token(keyword=option, value=part) for part in parts])
        if name == SEED:
            Common(seed=value)
    except CycloptsError as error:
        error.verbose = False
        raise InputError(f"{name}={word}: {one_line(error)}") from error
    except ValueError as error:
        raise InputError(f"{name}={word}: {one_line(error)}") from error
    # Workers may have another working folder.
    return value.absolute() if isinstance(value, Path) else value


def _when_given(hint: Any) -> Any:
    """The type of an option's value, None apart."""
    parts = [part for part in get_args(hint) if part is not NoneType]
    return parts[0] if NoneType in get_args(hint) else hint


def _refuse_impossible(grid: Grid, written: Mapping[Item, str]) -> None:
    """Raise InputError for a value that is impossible beside all values of the other axes."""
    everything = {item for item in written if item[0] != SEED}
    unproven, reasons, content = set(everything), dict[Item, str](), cache(content_of)
    for options in grid.combinations():
        if at_stake := unproven & options.items():
            reason = _why_not(options, content)
            if reason is None:
                unproven -= at_stake
            else:
                reasons |= dict.fromkeys(at_stake - reasons.keys(), reason)
    impossible = [item for item in written if item in unproven]
    for item in impossible:
        if _why_not(dict([item]), content) == reasons[item]:
            raise InputError(f"{written[item]}: {reasons[item]}")
    if impossible:
        all_are = unproven == everything
        what = "no configuration of the grid can be run" if all_are else written[impossible[0]]
        raise InputError(f"{what}: {reasons[impossible[0]]}")


def _why_not(options: Mapping[str, Any], content: Content) -> str | None:
    """Why options cannot be run, as far as is known before the robot moves."""
    try:
        cfg = LaserCfg(**options)
        task(cfg)
        identity(cfg, content)
    except (ValueError, OSError) as error:
        return one_line(error)
    return None
