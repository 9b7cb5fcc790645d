"""RAPID of ABB: robtarget, jointtarget, MoveL, MoveC, MoveJ, MoveAbsJ.

Conventions by the "Technical reference manual: RAPID Instructions, Functions and Data types": pos
[mm], orient a quaternion w first, speeddata [mm/s], zonedata [mm] whose second number is the zone
of the tool's path, at most half of the distance to the closest position.
"""

from collections.abc import Callable, MutableMapping
from functools import partial
from typing import ClassVar

import numpy as np

from armside.arrays import Array

from ...motion.instructions import MoveC, MoveJ, MoveL, Speed, Target
from .program_text import Aim, Frame
from .reader import End, Reader, Statement
from .scanner import NUMBER, Group, Number, Token, Value

MM = 1e-3
_V = (5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500)
_V += (2000, 2500, 3000, 4000, 5000, 6000, 7000)
SPEEDS = {f"v{n}": float(n) for n in _V}
ZONES = {f"z{n}": float(n) for n in (1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200)}
ZONES |= {"fine": 0.0, "z0": 0.3}
"""[mm/s], [mm]: names and values of the manual's speeddata and zonedata."""
ATTRIBUTES = ("sysmodule", "noview", "nostepin", "viewonly", "readonly")
LONGEST = 0.01
"""Largest deviation of a quaternion's length from 1."""
SIZES = {"robtarget": (3, 4, 4, 6), "jointtarget": (6, 6), "pose": (3, 4)}


class Rapid(Reader):
    """Reader of one module."""

    language = "rapid"
    grammar = (
        r"(?P<skip>[ \t\r\n\f]+|![^\n]*|^%%%[\s\S]*?%%%)|(?P<string>\"(?:[^\"\n]|\"\")*\")|"
        + NUMBER
        + r"|(?P<word>[A-Za-zÀ-ÖØ-öø-ÿ_][A-Za-zÀ-ÖØ-öø-ÿ_0-9]*)"
        + r"|(?P<sign>:=|[\\\[\](),;:{}+\-*/=<>?])"
    )
    end = (";",)
    routine, call, wait = ("proc", "endproc"), (), ("waittime",)
    moves: ClassVar = {"movel": MoveL, "movec": MoveC, "movej": MoveJ, "moveabsj": MoveJ}
    unmoving = frozenset({"confl", "confj", "singarea", "accset", "set", "reset", "tpwrite"})
    unmoving |= {"setdo", "setao", "setgo", "pulsedo", "tperase", "gripload"}
    unmoving |= {"actunit", "deactunit"}
    outside: MutableMapping[str, Value | Aim]
    """Data that stand in no routine."""

    def file(self) -> list[Statement]:
        cursor = self.cursor
        cursor.expect("module")
        cursor.take("word")
        while cursor.next.text in ("(", ",", ")", *ATTRIBUTES):
            cursor.take()
        found = self.body("endmodule")
        if cursor.next.kind != "end":
            cursor.fail(f"one module is read, {cursor.next} follows it")
        free = [name for name in self.routines if name not in self.called]
        if len(free) > 1 and "main" not in self.routines:
            which = f"which of {' and '.join(free[:4])} is the program: name one main"
            cursor.fail(which, cursor.tokens[0])
        return found

    def run(self, name: str, at: Token) -> None:
        data = self.data
        if not self.depth:
            self.outside = data
        self.data = dict(self.outside)
        super().run(name, at)
        self.data = data

    def statement(self, first: Token) -> list[Statement]:
        while self.cursor.has("local") or self.cursor.has("task"):
            first = self.cursor.next
        return super().statement(first)

    def declaration(self, first: Token) -> list[Statement]:
        cursor = self.cursor
        if not any(map(cursor.has, ("const", "pers", "var"))):
            cursor.fail(f"{first} is not understood")
        cursor.take("word")
        name = cursor.take("word").text
        value = cursor.value() if cursor.has(":=") else None
        return [] if value is None else [lambda: self.data.update({name: value})]

    def move(self, first: Token) -> list[Statement]:
        cursor, joints = self.cursor, first.text == "moveabsj"
        to = list[End]()
        for _ in range(2 if first.text == "movec" else 1):
            to.append(partial(self._joints, cursor.value()) if joints else self._target())
            if joints and cursor.has("\\"):
                cursor.expect("noeoffs")
            cursor.expect(",")
        speed, _ = cursor.value(), cursor.expect(",")
        zone, _ = cursor.value(), cursor.expect(",")
        tool, base = cursor.take("word"), Token("word", "wobj0", first.text_of, 0, 0)
        while cursor.has("\\"):
            if not cursor.has("tload", ":="):
                cursor.expect("wobj", ":=")
                base = cursor.next
            cursor.take("word")

        def frames() -> None:
            self.tool = self._frame(tool, "tool0", "true", (1,))
            self.base = self._frame(base, "wobj0", "false", (3, 4))

        def how() -> tuple[Speed, float]:
            size = MM * self._number(zone, ZONES, 7, 1)
            if (
                isinstance(speed, Token)
                and speed.text == "vmax"
                and first.text[4:] in ("j", "absj")
            ):
                return Speed(share=1.0), size
            return Speed(path=MM * self._number(speed, SPEEDS, 4, 0)), size

        return [frames, self.moving(first, to, how)]

    def _target(self) -> Callable[[], Aim]:
        """A robtarget; Offs of one where the offsets are numbers."""
        cursor = self.cursor
        given, by = cursor.value(), list[Value]()
        if not cursor.has("("):
            return partial(self._aim, given)
        if not isinstance(given, Token) or given.text != "offs":
            self.refuse(given, "a position must be a list, a name, or Offs of one by numbers")
        given = cursor.value()
        for _ in range(3):
            cursor.expect(",")
            by.append(cursor.value())
        cursor.expect(")")
        return lambda: self._aim(given).moved([MM * self.number(each).value for each in by])

    def _aim(self, given: Value) -> Aim:
        point, rotation, _, external = self._lists(given, "robtarget")
        return Aim.of(point, self._quaternion(rotation), MM, external)

    def _joints(self, given: Value) -> Target:
        motors, _ = self._lists(given, "jointtarget")
        return Target(motors=tuple(float(np.radians(n.value)) for n in motors))

    def _quaternion(self, numbers: tuple[Number, ...]) -> Array:
        q = np.array([number.value for number in numbers])
        if not abs(np.linalg.norm(q) - 1.0) < LONGEST:
            self.refuse(numbers[0], "a quaternion must have length 1")
        return q

    def _frame(self, name: Token, zero: str, held: str, poses: tuple[int, ...]) -> Frame:
        """Of tooldata or wobjdata, the product of its poses; tool0 and wobj0 are no shift."""
        if name.text not in self.data:
            return Frame(name.text) if name.text == zero else Frame(name.text, None)
        group = self._group(name, 3 if zero == "tool0" else 5, f"data of {name}")
        if not isinstance(group.items[0], Token) or group.items[0].text != held:
            self.refuse(group, f"{name}: a robot that holds its work is not understood")
        if zero == "wobj0" and str(group.items[1]) != "true":
            return Frame(name.text, None)  # a mechanical unit moves it
        pose = np.eye(4)
        for index in poses:
            point, rotation = self._lists(group.items[index], "pose")
            pose = pose @ Aim.of(point, self._quaternion(rotation), MM).pose
        return Frame(name.text, pose)

    def _number(self, given: Value, names: dict[str, float], n: int, index: int) -> float:
        """Of speeddata or zonedata by name, or one of its n numbers."""
        if isinstance(given, Token) and given.text not in self.data and given.text in names:
            return names[given.text]
        group = self._group(given, n, "speeddata" if n == 4 else "zonedata")
        if isinstance(first := group.items[0], Token) and first.text == "true":
            return 0.0  # finep
        return self.number(group.items[index]).value

    def _lists(self, given: Value, kind: str) -> list[tuple[Number, ...]]:
        parts = self._group(given, len(SIZES[kind]), kind).items
        each = zip(parts, SIZES[kind], strict=True)
        return [self._group(part, n, kind).numbers(n, f"a part of {kind}") for part, n in each]

    def _group(self, given: Value, n: int, kind: str) -> Group:
        value = self.named(given)
        if not isinstance(value, Group) or len(value.items) != n:
            self.refuse(given, f"{kind} must be a list of {n} values")
        return value
