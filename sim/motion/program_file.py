"""Motion programs as TOML files, in degrees, mm, mm/s and percent.

    start = [0, 0, 0, 0, 0, 0]                # each motor's angle, deg; the zero pose if left out

    [targets.corner]                          # named targets; a move may also hold one inline
    position = [968, -127, 1030]              # mm, TCP0 in base axes
    orientation = [0.7071, 0, 0.7071, 0]      # quaternion, w first; left out: unchanged

    [[program]]
    do = "MoveJ"
    to = "corner"                             # or { motors = [...] }, { position = [...] }
    speed = "80 %"                            # of the joints' speed, or a number: mm/s
    zone = 10                                 # mm; left out: a stop point

    [[program]]
    do = "Wait"
    seconds = 0.5

`[dynamics]` may hold joint_acceleration [rad/s^2], path_acceleration [m/s^2], jerk_time [ms].
"""

import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .instructions import (
    Dynamics,
    Instruction,
    MoveC,
    MoveJ,
    MoveL,
    Program,
    ProgramError,
    Speed,
    Target,
    Wait,
)

MM, MS, DEG = 1e-3, 1e-3, np.pi / 180.0


def read_program(path: Path, n_axes: int = 6, dynamics: Dynamics = Dynamics()) -> Program:
    """Program of a file, for a robot of so many axes.

    dynamics: limits where the file has none.

    Raises ProgramError with file, line and reason, OSError where the file cannot be read.
    """
    text = path.read_text(encoding="utf-8-sig")
    return parse_program(text, source=path.name, n_axes=n_axes, dynamics=dynamics)


def parse_program(
    text: str, *, source: str = "program", n_axes: int = 6, dynamics: Dynamics = Dynamics()
) -> Program:
    """Program of a text; the module docstring describes its form."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ProgramError(f"{source}: {error}") from error
    return _Reader(text, source).program(data, n_axes, dynamics)


class _Reader:
    """Reader of one text, with the lines of its tables for messages."""

    def __init__(self, text: str, source: str) -> None:
        self.source, self.text_lines = source, text.splitlines()
        heads = [i for i, line in enumerate(self.text_lines) if re.match(r"\s*\[", line)]
        ends = [*heads[1:], len(self.text_lines)]
        self.blocks = [(self.text_lines[a].strip(), a, b) for a, b in zip(heads, ends, strict=True)]

    def program(self, data: Mapping[str, Any], n: int, known: Dynamics) -> Program:
        whole = (0, len(self.text_lines))
        self._in(whole, _only, data, {"start", "targets", "dynamics", "program"})
        targets = {
            name: self._in(self._named("targets", name), _target, table, n)
            for name, table in self._table(data, "targets").items()
        }
        dynamics = self._table(data, "dynamics")
        places = [(a, b) for head, a, b in self.blocks if re.match(r"\[\[\s*program\s*\]\]", head)]
        steps = data.get("program", [])
        if not (isinstance(steps, list) and all(isinstance(s, dict) for s in steps)):
            raise ProgramError(f"{self.source}: program must be a list of [[program]] tables")
        if len(steps) != len(places):
            raise ProgramError(f"{self.source}: write each instruction as a [[program]] table")
        instructions = tuple(
            self._in(place, _instruction, step, targets, n)
            for step, place in zip(steps, places, strict=True)
        )
        top = (0, self.blocks[0][1] if self.blocks else len(self.text_lines))
        return Program(
            instructions=instructions,
            start=self._in(top, _numbers, "start", data.get("start", [0] * n), n, DEG),
            dynamics=self._in(self._named("dynamics"), _dynamics, dynamics, known),
            source=self.source,
            lines=tuple(a + 1 for a, _ in places),
        )

    def _table(self, data: Mapping[str, Any], name: str) -> Mapping[str, Any]:
        table = data.get(name, {})
        if not isinstance(table, dict):
            raise ProgramError(f"{self.source}: {name} must be a table")
        return table

    def _named(self, *names: str) -> tuple[int, int]:
        """Lines of a table; the whole text if it has no header of its own."""
        for head, a, b in self.blocks:
            if re.sub(r"[\s\"']", "", head).strip("[]") == ".".join(names):
                return a, b
        return 0, len(self.text_lines)

    def _in(self, place: tuple[int, int], make: Callable[..., Any], *of: Any) -> Any:
        """Result of `make`; errors get file and line, that of the key they begin with."""
        try:
            return make(*of)
        except ValueError as error:
            word = re.match(r"\w+", str(error))
            key = re.compile(rf"\s*{word.group(0)}\s*=" if word else "(?!)")  # none without a word
            line = next((i for i in range(*place) if key.match(self.text_lines[i])), place[0])
            raise ProgramError(f"{self.source}, line {line + 1}: {error}") from error


def _only(table: Mapping[str, Any], names: set[str]) -> None:
    for name in table:
        if name not in names:
            raise ValueError(f"{name} is not known here. Known: {', '.join(sorted(names))}")


def _instruction(table: Mapping[str, Any], targets: Mapping[str, Target], n: int) -> Instruction:
    kind = _required(table, "do")
    if kind == "Wait":
        _only(table, {"do", "seconds"})
        return Wait(seconds=_number("seconds", _required(table, "seconds")))
    if kind not in ("MoveJ", "MoveL", "MoveC"):
        raise ValueError(f"do: unknown instruction {kind!r}. Known: MoveJ, MoveL, MoveC, Wait")
    _only(table, {"do", "to", "speed", "zone"} | ({"via"} if kind == "MoveC" else set()))
    to, speed = _to(_required(table, "to"), targets, n), _speed(_required(table, "speed"))
    zone = _number("zone", table.get("zone", 0.0)) * MM
    if kind != "MoveC":
        return (MoveJ if kind == "MoveJ" else MoveL)(to=to, speed=speed, zone=zone)
    via = _to(_required(table, "via"), targets, n, "via").position
    if via is None:
        raise ValueError("via needs a position")
    return MoveC(to=to, speed=speed, zone=zone, via=via)


def _required(table: Mapping[str, Any], name: str) -> Any:
    if name not in table:
        raise ValueError(f"{name} is missing")
    return table[name]


def _to(value: Any, targets: Mapping[str, Target], n: int, key: str = "to") -> Target:
    if isinstance(value, str):
        if value not in targets:
            known = ", ".join(targets) or "none"
            raise ValueError(f"{key}: unknown target {value!r}. Targets: {known}")
        return targets[value]
    if not isinstance(value, dict):
        raise ValueError(f"{key} must be the name of a target or a table, got {value!r}")
    return _target(value, n)


def _target(table: Mapping[str, Any], n_axes: int) -> Target:
    _only(table, {"motors", "position", "orientation", "near"})

    def numbers(name: str, n: int, unit: float) -> Any:
        return _numbers(name, table[name], n, unit) if name in table else None

    return Target(
        motors=numbers("motors", n_axes, DEG),
        position=numbers("position", 3, MM),
        quaternion=numbers("orientation", 4, 1.0),
        near=numbers("near", n_axes, DEG),
    )


def _speed(value: Any) -> Speed:
    if isinstance(value, str):
        percent = re.fullmatch(r"\s*([0-9.]+)\s*%\s*", value)
        if not percent:
            raise ValueError(f'speed must be mm/s or a percentage like "80 %", got {value!r}')
        return Speed(share=_number("speed", float(percent.group(1))) / 100.0)
    return Speed(path=_number("speed", value) * MM)


def _dynamics(table: Mapping[str, Any], known: Dynamics) -> Dynamics:
    n_axes = len(known.joint_acceleration)
    read: dict[str, Callable[[str, Any], Any]] = {
        "joint_acceleration": lambda name, value: _numbers(name, value, n_axes, 1.0),
        "path_acceleration": _number,
        "jerk_time": lambda name, value: _number(name, value) * MS,
    }
    _only(table, set(read))
    return replace(known, **{name: read[name](name, value) for name, value in table.items()})


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
        raise ValueError(f"{name} must be a finite number, got {value!r}")
    return float(value)


def _numbers(name: str, values: Any, n: int, unit: float) -> tuple[float, ...]:
    if not isinstance(values, Sequence) or isinstance(values, str) or len(values) != n:
        raise ValueError(f"{name} must be {n} numbers, got {values!r}")
    return tuple(_number(name, value) * unit for value in values)
