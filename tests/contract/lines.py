"""Command lines drawn from the options of the commands, and those of the table of findings."""

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from enum import IntEnum
from inspect import Parameter as Argument
from inspect import signature
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

import numpy as np
from cyclopts import Parameter

from armside.scripts import cli
from armside.scripts.shell.options import FileToRead, FileToWrite, Folder

from .files import BAD_TWINS, MOTION, NEVER, POSES, READ, RUNS, TWINS
from .findings import FINDINGS

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
    stated = [part for each in (hint, *get_args(hint)) for part in get_args(each)]
    role = next((roles[kind] for kind in roles if all(p in stated for p in get_args(kind))), "")
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


class Kind(IntEnum):
    """Kind of the words of an option, the worst last."""

    ORDINARY = 0
    BOUNDARY = 1
    ABSURD = 2
    """Of the right type; no sensible person means it."""
    MALFORMED = 3
    """Never valid."""


class Line(NamedTuple):
    """Words of a command line, and the kind of its worst option."""

    words: tuple[str, ...]
    kind: Kind


BASE: dict[str, tuple[str, ...]] = {
    "laser": ("--iterations", "0"),
    "cut": ("../files/contour.toml", "--iterations", "0"),
    "imu": ("--motion", "rest", "--off", "3", "--on", "3"),
    "compare": ("--poses", "p1", "--speeds", "60", "--iterations", "1"),
    "replay": ("../files/run", "--save", "a.rrd"),
    "identify-plant": ("../files/record.csv", "--structures", "oe", "--largest-order", "2"),
    "learn": ("--iterations", "1", "--samples", "50"),
    "tune": ("--trials", "1", "--episodes", "1", "--iterations", "1", "--pose", "p1"),
    "sweep": ("iterations=0",),
    "reproduce": ("8.3",),
    "convert": ("../files/run", "--file", "a.csv"),
    "robot": ("check",),
    "measure": ("../files/data.csv", "--gear", "1"),
    "train": ("--robots", "1", "--steps", "5"),
    "commission": ("--recordings", "../files/run"),
    "calibrate-arm": (f"../files/{POSES}", "--robot", "ur10", "--harmonics", "0"),
    "serve": ("--idle", "0.2"),
    "scan": ("read",),
    "gears": (f"../files/{MOTION}", "--robot", "ur10", "--largest-order", "60"),
}
"""Words that make a command short, unless an option takes their place."""
FOR_EVER = ("--web", "--idle")
"""Options that ask to go on until Ctrl-C, without work by which a limit could be kept."""
WEIGHTS = {
    **{"laser": 5.0, "measure": 3.0, "sweep": 3.0, "design": 2.0, "replay": 2.0, "convert": 2.0},
    "reproduce": 0.5,
}
"""Of the commands by the kinds of input that they read; 1 for those that are not named."""
FLOATS = {
    Kind.ORDINARY: ("1", "2.5", "40", "0.5"),
    Kind.BOUNDARY: ("0", "-0.0", "-1", "1e-6", "0.1", "1", "100", "1000"),
    Kind.ABSURD: ("1e308", "-1e308", "1e-300", "5e-324", "1e30", "-1e30", "1e15", "1.7e308"),
    Kind.MALFORMED: ("nan", "inf", "-inf", "1e999", "abc", "1,5", "0x1p3", "1e", "", "²"),
}
INTEGERS = {
    Kind.ORDINARY: ("1", "2", "3"),
    Kind.BOUNDARY: ("0", "-1", "1", "2"),
    Kind.ABSURD: ("2147483648", "9223372036854775808", "1" + "0" * 30, "-9223372036854775809"),
    Kind.MALFORMED: ("1.5", "abc", "nan", "inf", "1e400", "", "½", "9" * 5000),
}
TEXTS = {
    Kind.ORDINARY: (
        *("p1", "two-mass", "servo", "pose=p1", "circles", "start", "8.4", "gamma=0.5"),
        *("ur10", "large", "theta_2", "cut-1"),
    ),
    Kind.BOUNDARY: ("p9", "a b", "../files/model.json", "seed=0:2", "speed=40,", "=", "gamma="),
    Kind.ABSURD: (
        *("x" * 5000, "../files/fifo.toml", "/dev/zero", "seed=0:100000000", "\udcff", "漢字"),
        *(
            "seed=9223372036854775808",
            "sqlite:///../files/data.csv",
            "\x1b[31m",
            "a\nb",
            "\u202e",
            "--",
        ),
        *("../files/gain.json", "../files/long.json", "../files/deep.json", "../files/huge.json"),
        *("sqlite+aiosqlite:///n/x.db", "gamma=1e308", "contour=/dev/zero", "speed=1e-300"),
    ),
    Kind.MALFORMED: ("", "--nonsense"),
}
OUTPUTS = {
    Kind.ORDINARY: ("out.rrd", "out.png", "out.gif", "out.csv", "out"),
    Kind.BOUNDARY: (".", "..", "a/b/c.csv", "ä.csv", "new/../out"),
    Kind.ABSURD: ("/dev/null", "/dev/full", "/proc/a.csv", "\udcff.csv", "../files/fifo.toml"),
    Kind.MALFORMED: ("x" * 300, "x" * 300 + ".csv", "a/" * 3000 + "b.png", ""),
}

_TOML = tuple(name for name in READ if name.endswith(".toml"))
GIVEN: dict[str, Sequence[str]] = {
    "": (*RUNS, *READ),
    "--identification": (*RUNS, *NEVER),
    "--recordings": (*RUNS, *READ),
    "--twin": (*TWINS, "run", *NEVER),
    "--individual": (*_TOML, *NEVER),
    "--gears": (*_TOML, *NEVER),
}
"""Names of what is given to be read, of positional arguments and options that say no more of it."""


def line(seed: int) -> Line:
    """The command line of a seed: first those of the table, then drawn ones."""
    if seed < len(FINDINGS):
        return Line(FINDINGS[seed], Kind.ABSURD)
    rng = np.random.default_rng(seed)
    names = list(cli.COMMANDS)
    weights = np.array([WEIGHTS.get(name, 1.0) for name in names])
    name = names[int(rng.choice(len(names), p=weights / weights.sum()))]
    known = [option for option in options_of(cli.load(name)) if option.name not in FOR_EVER]
    n = min(len(known), int(rng.choice([1, 2, 3], p=[0.5, 0.35, 0.15])))
    kinds = [Kind(int(k)) for k in rng.choice(4, n, p=[0.1, 0.15, 0.4, 0.35])]
    kinds[0] = max(kinds[0], Kind.BOUNDARY)
    chosen = [known[int(i)] for i in rng.choice(len(known), n, replace=False)]
    drawn = [_words(option, kind, rng) for option, kind in zip(chosen, kinds, strict=True)]
    first = next((option for option in known if not option.name), None)
    base = _base(name, {option.name for option in chosen}, positional=first in chosen)
    words = (name, *base, *(word for words in drawn for word in words))
    return Line(words, max(kinds))


def _base(name: str, given: set[str], positional: bool) -> tuple[str, ...]:
    """The words of BASE whose options are not given; positional: the first positional is given."""
    kept, option = list[str](), ""
    for word in BASE.get(name, ()):
        option = word if word.startswith("--") else option
        if option not in given if option else not positional:
            kept.append(word)
    return tuple(kept)


def _words(option: Option, kind: Kind, rng: np.random.Generator) -> list[str]:
    """Words of one option, of which at least one is of that kind."""
    head = [option.name] if option.name else []
    if option.type is bool:
        return [f"{option.name}=maybe"] if kind is Kind.MALFORMED else head
    n = int(rng.integers(1, 4)) if option.words is None else option.words
    if kind is Kind.MALFORMED and option.words not in (None, 1) and rng.random() < 0.3:
        n += int(rng.choice([-1, 1]))
    others = [str(rng.choice(_values(option, Kind.ORDINARY))) for _ in range(n)]
    if n:
        others[int(rng.integers(n))] = str(rng.choice(_values(option, kind)))
    return head + others


def _values(option: Option, kind: Kind) -> Sequence[str]:
    if get_origin(option.type) is Union:
        each = [option._replace(type=part) for part in get_args(option.type)]
        return [value for one in each for value in _values(one, kind)]
    if get_origin(option.type) is Literal:
        good = [str(value) for value in get_args(option.type)]
        return good if kind < Kind.ABSURD else [*TEXTS[Kind.MALFORMED], "odd", good[0].upper()]
    if option.type is Path:
        return _paths(option, kind)
    tables: dict[Any, dict[Kind, Sequence[str]]] = {float: FLOATS, int: INTEGERS}
    return tables.get(option.type, TEXTS)[kind]


def _paths(option: Option, kind: Kind) -> Sequence[str]:
    if option.name and option.name not in GIVEN and option.role != "read":
        return OUTPUTS[kind]
    given = GIVEN.get(option.name, READ)
    if kind is Kind.MALFORMED:
        never = [name for name in (*NEVER, *BAD_TWINS) if name in given]
        return [*(f"../files/{name}" for name in never), "/dev/zero", "x" * 300]
    return [*(f"../files/{name}" for name in given), "/dev/zero", "."]
