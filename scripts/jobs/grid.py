"""The grid of `armside sweep`: axes over the options of `armside laser`, and its points.

An axis is written `option=value,value`; whole numbers also `first:last+1`, values of six motors
`0.9/0.9/0.8/0.8/0.8/0.8`, and none of several `without=,ripple`.
"""

import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from itertools import product
from math import prod
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from cyclopts import CycloptsError, Token

from armside.sim.records.summary import plain

from ..cutting.cut_run import run
from ..cutting.options import LaserCfg
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import InputError, one_line, unknown
from ..shell.options import Common, read_value
from .dataset import Dataset, Row, measures
from .queue import FAILED, complete
from .resolved import Resolver, key_of, resolved
from .store import code_fingerprint
from .workers import Engine, WorkerDied

SEED, ROBOT = "seed", "robot"
TYPES: Mapping[str, Any] = get_type_hints(LaserCfg) | {SEED: int}
"""Types of the options that can be axes."""
OF_A_POINT = Effort(0.5, 5e3)
Item = tuple[str, Hashable]
"""An option and one of its values."""
_RANGE = re.compile(r"(-?\d+):(-?\d+)")


@dataclass(frozen=True)
class Point:
    """Options of `armside laser` and a seed."""

    key: str
    """Hash of the whole configuration: resolved options, content of files, and seed."""
    options: Mapping[str, Any]
    """Options, typed; those left out have their defaults."""
    seed: int

    def run(self) -> Row:
        """The row of its run. An exception becomes the row of a failure."""
        try:
            outcome = run(LaserCfg(**self.options), self.seed)
            if key_of(self.options, self.seed) != self.key:
                error = "a file of its options is not what it was when the sweep began"
                return self._row(status=FAILED, error=error)
            return self._row(status=outcome["status"], **measures(outcome))
        except Exception as error:
            return self.failed(error)

    def failed(self, error: Exception) -> Row:
        """Its row without a result."""
        kind = "" if isinstance(error, WorkerDied) else f"{type(error).__name__}: "
        return self._row(status=FAILED, error=kind + one_line(error))

    def _row(self, **columns: Any) -> Row:
        try:
            options = resolved(LaserCfg(**self.options))
        except (ValueError, OSError):
            options = plain(self.options)
            if options.get("individual") is not None:
                options["individual"] = str(options["individual"])
        made_with = {"version": version("armside"), "code": code_fingerprint()[:12]}
        return {"key": self.key, "seed": self.seed, **options, **made_with, **columns}


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some options."""

    axes: Mapping[str, Sequence[Any]]
    resolver: Resolver = field(default_factory=Resolver, compare=False, repr=False)

    def __len__(self) -> int:
        """Number of combinations; there are fewer points where several mean the same run."""
        return prod(len(values) for values in self.axes.values())

    def __iter__(self) -> Iterator[Point]:
        """The points, the last axis fastest, each configuration once."""
        seen = set[str]()
        for options in self.combinations():
            seed = options.pop(SEED)
            key = self.resolver.key(options, seed)
            if key not in seen:
                seen.add(key)
                yield Point(key=key, options=options, seed=seed)

    def combinations(self) -> Iterator[dict[str, Any]]:
        """Every combination of the values, by name, the last axis fastest."""
        for values in product(*self.axes.values()):
            yield dict(zip(self.axes, values, strict=True))


def parse(words: Sequence[str], seed: int) -> Grid:
    """A grid from the words of a command line; `seed` where no axis gives any. Raises InputError
    for an axis that is no option of `armside laser`, is there twice or has a value that the option
    does not take, alone or beside any of the other axes' values."""
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
    grid = Grid(axes | {SEED: axes.get(SEED, (seed,))})
    refuse_absurd(f"{len(grid)} configurations", OF_A_POINT * len(grid), kept=True)
    _refuse_impossible(grid, written)
    return grid


def _values(name: str, text: str) -> dict[Any, str]:
    hint = _when_given(TYPES[name])
    numbers = {int, float} & {hint, *get_args(hint)}
    words = text.split(",")
    if numbers and (spanned := _RANGE.fullmatch(text)):
        first, end = int(spanned[1]), int(spanned[2])
        refuse_absurd(f"{end - first} values of {name}", OF_A_POINT * (end - first), kept=True)
        words = [str(i) for i in range(first, end)]
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
    option, parts = f"--{name.replace('_', '-')}", word.split("/") if several else [word]
    try:
        value = read_value(TYPES[name], [Token(keyword=option, value=part) for part in parts])
        if name == SEED:
            Common(seed=value)
    except (CycloptsError, ValueError) as error:
        if isinstance(error, CycloptsError):
            error.verbose = False
        raise InputError(f"{name}={word}: {one_line(error)}") from error
    # Workers may have another working folder.
    if name == ROBOT and value.endswith(".toml"):
        return str(Path(value).absolute())
    return value.absolute() if isinstance(value, Path) else value


def _when_given(hint: Any) -> Any:
    parts = [part for part in get_args(hint) if part is not NoneType]
    return parts[0] if NoneType in get_args(hint) else hint


def _refuse_impossible(grid: Grid, written: Mapping[Item, str]) -> None:
    """Raise InputError for a value that is impossible beside all values of the other axes."""
    everything = {item for item in written if item[0] != SEED}
    unproven, reasons = set(everything), dict[Item, str]()
    without_seed = {name: values for name, values in grid.axes.items() if name != SEED}
    for options in Grid(without_seed).combinations():
        if at_stake := unproven & options.items():
            if refused := grid.resolver.refused(options):
                reasons |= dict.fromkeys(at_stake - reasons.keys(), refused)
            else:
                unproven -= at_stake
    impossible = [item for item in written if item in unproven]
    for item in impossible:
        if grid.resolver.refused(dict([item])) == reasons[item]:
            raise InputError(f"{written[item]}: {reasons[item]}")
    if impossible:
        all_are = unproven == everything
        what = "no configuration of the grid can be run" if all_are else written[impossible[0]]
        raise InputError(f"{what}: {reasons[impossible[0]]}")


def run_grid(
    points: Iterable[Point],
    rows: Dataset,
    engine: Engine,
    step: Callable[[], None] = lambda: None,
    *,
    retry_failed: bool = False,
    waiting: Callable[[int], None] = lambda n: None,
) -> Counter[str]:
    """Bring a dataset up to all points of a grid; `step` is called for each that has a row. The
    rest, the returned counts and the errors are those of `queue.complete`."""
    try:
        return complete(
            {point.key: point for point in points},
            rows,
            engine,
            done=lambda _: step(),
            retry_failed=retry_failed,
            waiting=waiting,
        )
    finally:
        rows.gather()
