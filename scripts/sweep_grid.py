"""The grid of `armside sweep`: axes over the options of `armside laser`, and a key for each point.

An axis is written `option=value,value`; whole numbers also `first:last+1`, values of six motors
`0.9/0.9/0.8/0.8/0.8/0.8`.
"""

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import product
from typing import Any

from cyclopts import CycloptsError

from .errors import InputError, one_line
from .laser import LaserCfg
from .registry import unknown
from .summary import plain

SEED = "seed"
_RANGE = re.compile(r"(-?\d+):(-?\d+)")


@dataclass(frozen=True)
class Point:
    """One configuration of a grid."""

    key: str
    """Hash of the whole configuration, defaults and seed included."""
    options: Mapping[str, Any]
    """Options of `armside laser`, typed; those left out have their defaults."""
    seed: int


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some options."""

    axes: Mapping[str, Sequence[Any]]

    def __len__(self) -> int:
        n = 1
        for values in self.axes.values():
            n *= len(values)
        return n

    def __iter__(self) -> Iterator[Point]:
        """The points, the last axis fastest."""
        for values in product(*self.axes.values()):
            options = dict(zip(self.axes, values, strict=True))
            seed = options.pop(SEED)
            yield Point(key=key_of(options, seed), options=options, seed=seed)


def parse(words: Sequence[str], seed: int) -> Grid:
    """A grid from the words of a command line; `seed` where no axis gives any.

    Raises:
        InputError: an axis that is no option of `armside laser`, is there twice or has a value
            that the option does not take.
    """
    names = [field.name for field in fields(LaserCfg)]
    axes: dict[str, Sequence[Any]] = {}
    for word in words:
        name, equals, values = word.partition("=")
        if not equals:
            raise InputError(f"a grid is written option=value,value; got {word!r}")
        name = name.lstrip("-").replace("-", "_")
        if name not in (*names, SEED):
            raise unknown("option of laser", name, [*names, SEED])
        if name in axes:
            raise InputError(f"{name} is given twice")
        axes[name] = _values(name, values)
    if not axes:
        raise InputError("give at least one axis, such as gamma=0.5,0.9 or pose=p1,p2,p3")
    return Grid(axes | {SEED: axes.get(SEED, (seed,))})


def key_of(options: Mapping[str, Any], seed: int) -> str:
    """Sixteen hexadecimal digits of the whole configuration."""
    # Without checking: a point that cannot be run has a key too. Defaults may depend on these two.
    decisive = {name: options[name] for name in ("robot", "measure") if name in options}
    whole = asdict(LaserCfg(**decisive)) | dict(options) | {"experiment": "laser", SEED: seed}
    text = json.dumps(plain(whole), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _values(name: str, text: str) -> Sequence[Any]:
    spanned = _RANGE.fullmatch(text)
    words = (
        [str(i) for i in range(int(spanned[1]), int(spanned[2]))] if spanned else text.split(",")
    )
    values = [_value(name, word.strip()) for word in words]
    if not values:
        raise InputError(f"{name}={text} has no values")
    if len(set(values)) < len(values):
        raise InputError(f"{name}={text} has a value twice")
    return values


def _value(name: str, word: str) -> Any:
    """One value, read and checked as the command line of `armside laser` does."""
    from .cli import make_app

    if not word:
        raise InputError(f"{name} has an empty value")
    option = f"--{name.replace('_', '-')}"
    try:
        _, bound, _ = make_app("laser").parse_args(["laser", option, *word.split("/")])
    except (CycloptsError, ValueError) as error:
        raise InputError(f"{name}={word}: {one_line(error)}") from error
    bound.apply_defaults()
    owner = bound.arguments["common" if name == SEED else "cfg"]
    return getattr(owner, name)


def configuration(point: Point) -> LaserCfg:
    """The checked options of a point. Raises ValueError where they do not go together."""
    return LaserCfg(**point.options)
