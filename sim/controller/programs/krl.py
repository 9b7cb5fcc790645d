"""KRL of KUKA: E6POS, E6AXIS, LIN, CIRC, PTP, also as its inline forms leave them.

Conventions by KUKA's manuals: X, Y, Z [mm], A, B, C [deg] with R = Rz(A) Ry(B) Rx(C), $VEL.CP
[m/s], $APO.CDIS [mm], at most half of the distance to a point. A blend of PTP is in percent, has no
length, and is read as none.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np

from armside.kinematics.rotation import from_roll_pitch_yaw, to_quaternion

from ...motion.instructions import MoveC, MoveJ, MoveL, Speed, Target, Wait
from .program_text import Aim, Frame
from .reader import End, Reader, Statement
from .scanner import NUMBER, Group, Number, Text, Token, Value

MM = 1e-3
TYPES = {"decl", "global", "const", "e6pos", "pos", "frame", "e6axis", "axis", "ldat", "pdat"}
TYPES |= {"fdat", "int", "real", "bool", "char"}
UNMOVING = {"$advance", "$acc.cp", "$acc.ori1", "$acc.ori2", "$acc_axis", "$bwdstart", "$out"}
UNMOVING |= {"$anout", "$vel.ori1", "$vel.ori2", "$ori_type", "$circ_type", "$h_pos"}
UNMOVING |= {"$apo.cptp", "$apo.cvel", "$apo.cori", "$act_tool", "$act_base", "$load"}
"""Variables that leave the path of LIN and CIRC, blended by C_DIS, as it is."""
BAS = {"#vel_cp": "$vel.cp", "#cp_params": "$vel.cp", "#vel_ptp": "$vel_axis"}
BAS |= {"#ptp_params": "$vel_axis", "#tool": "tool_no", "#base": "base_no", "#initmov": "#initmov"}
BAS |= dict.fromkeys(("#acc_cp", "#acc_ptp", "#ptp_dat", "#frames"), "")
POSE, AXES = ("x", "y", "z", "a", "b", "c"), ("a1", "a2", "a3", "a4", "a5", "a6")


class Krl(Reader):
    """Reader of a `.src`, with its `.dat` where there is one."""

    language = "krl"
    grammar = (
        r"(?P<skip>[ \t\r\f]+|;[^\n]*|^&[^\n]*)|(?P<newline>\n)|"
        r"(?P<string>\"[^\"\n]*\"|'[BHbh][0-9A-Fa-f]+')|"
        + NUMBER
        + r"|(?P<word>[#$]?[A-Za-z_][A-Za-z_0-9$]*(?:\.[A-Za-z_][A-Za-z_0-9]*)*)"
        r"|(?P<sign>==|[\[\](),:{}+\-*/=<>?])"
    )
    end = ("newline",)
    routine, call, wait = ("def", "end"), ("(", ")"), ("wait", "sec")
    moves: ClassVar = {"ptp": MoveJ, "lin": MoveL, "circ": MoveC}
    unmoving = frozenset(("ext", "extfct", "set_cd_params"))

    def __init__(self, texts: Sequence[Text]) -> None:
        super().__init__(texts)
        self.tool, self.base = Frame("$TOOL", None), Frame("$BASE", None)  # as the last run left it
        self.own = dict[str, Value | Aim | None]()

    def run(self, name: str, at: Token) -> None:
        """With variables of its own, and those of their names as they were after it."""
        outer, self.own = self.own, {}
        super().run(name, at)
        for variable, value in self.own.items():
            self.data.pop(variable, None)
            if value is not None:
                self.data[variable] = value
        self.own = outer

    def entry(self) -> str:
        """The first routine is that of the file."""
        return next(iter(self.routines), "")

    def file(self) -> list[Statement]:
        cursor = self.cursor
        while cursor.next.kind == "newline":
            cursor.take()
        if not cursor.has("defdat"):
            return self.body("")
        cursor.take("word")
        cursor.has("public")
        found = self.body("enddat")
        return found + self.body("")

    def statement(self, first: Token) -> list[Statement]:
        cursor = self.cursor
        cursor.has("global")
        if cursor.has("interrupt"):  # the stop message of every program is understood, no other
            if cursor.has("decl"):
                while not self.ends and cursor.next.text != "ir_stopm":
                    cursor.take()
                if not cursor.has("ir_stopm", "(", ")"):
                    cursor.fail("of interrupts only that to IR_STOPM is understood", first)
            else:
                cursor.expect("on")
                cursor.number()
            return []
        start = cursor.at
        if cursor.has("wait", "sec"):
            if isinstance(value := cursor.value(), Number) and value.value == 0.0:
                return [self._stop]
            cursor.at = start
            return [self._stop, *super().statement(first)]
        return super().statement(first)

    def _stop(self) -> None:
        """The advance run stops: the move before it ends in its target, and is not blended."""
        if self.instructions and not isinstance(last := self.instructions[-1], Wait):
            self.instructions[-1] = replace(last, zone=0.0)

    def declaration(self, first: Token) -> list[Statement]:
        """Type, names and value of a variable; its value alone; or BAS(#NAME, value)."""
        cursor = self.cursor
        if cursor.has("bas", "("):
            name = cursor.take("word")
            if name.text not in BAS:
                cursor.fail(f"{name} is not understood", name)
            number = cursor.number() if cursor.has(",") else Number(0.0, first.text_of, 0, 0)
            cursor.expect(")")
            return [lambda: self._set(BAS[name.text], number, name)]
        declared, going = False, cursor.has("continue")
        if going and cursor.take("newline") and self.ends:
            return []  # it is for the next line alone, also for a blank one
        first = cursor.next
        while cursor.next.text in TYPES or (
            declared and cursor.tokens[cursor.at + 1].kind == "word"
        ):
            cursor.take()
            declared = True
        at, variable = cursor.next, self._name()
        own = [variable]
        while declared and cursor.has(","):
            own.append(variable := self._name())
        if declared and self.ends:
            return [lambda: self.own.update({name: self.data.pop(name, None) for name in own})]
        if not cursor.has("="):
            cursor.fail(f"{first} is not understood", first)
        value = self._value()
        stops = variable.startswith(("$out[", "$anout[", "$act_")) and not going
        return [*[self._stop] * stops, lambda: self._set(variable, value, at)]

    def _name(self) -> str:
        """A name, with its index where it has one."""
        name = self.cursor.take("word").text
        if not self.cursor.has("[") or self.cursor.has("]"):
            return name
        index = self.cursor.number().value
        self.cursor.expect("]")
        return f"{name}[{index:g}]"

    def _value(self) -> Value:
        first = self.cursor.next
        if first.kind == "word":
            return first._replace(text=self._name())
        return self.cursor.value("{}")

    def _set(self, name: str, value: Value, at: Token) -> None:
        base = name.partition("[")[0]
        match base:
            case "$tool" | "tool_no":
                self.tool = self._frame(value, "tool_data")
            case "$base" | "base_no":
                self.base = self._frame(value, "base_data")
            case "#initmov":  # as bas.src has it; its speed and blend are not in the file
                for setting in ("$vel.cp", "$apo.cdis", "$vel_axis", "$advance"):
                    self.data.pop(setting, None)
                one = Number(1.0, at.text_of, at.start, at.end)
                self.tool, self.base = self._frame(one, "tool_data"), Frame("base_data[0]")
            case "pdat_act" if isinstance(value, Token) and value.text not in self.data:
                pass  # PDEFAULT of $config.dat, whose blend is in percent
            case "fdat_act" | "ldat_act" | "pdat_act":
                to = {"tool_no": "tool_no", "base_no": "base_no", "ipo_frame": "$ipo_mode"}
                fields = self._fields(value, ())
                if base != "pdat_act" or str(fields.get("apo_mode")) == "#cdis":
                    to["apo_dist"] = "$apo.cdis"
                for field, given in fields.items():
                    if field in to:
                        self._set(to[field], given, at)
            case "$ipo_mode":
                if not isinstance(value, Token) or value.text != "#base":
                    self.refuse(value, "$IPO_MODE must be #BASE")
            case "$vel.cp" | "$apo.cdis" | "$vel_axis":
                self.data[base] = self.number(value)
            case _:
                if base and base not in UNMOVING and (base[0] == "$" or "." in base):
                    self.refuse(at, f"{at} is not understood")
                known = self.data.get(value.text) if isinstance(value, Token) else None
                self.data[name] = known or value  # a copy: what it is a copy of may change

    def _frame(self, value: Value, numbered: str) -> Frame:
        """A zero frame, a frame, or one by number, of which 0 is the flange or the robot's base."""
        if isinstance(value, Number):
            if value.value == 0.0:
                return Frame(f"{numbered}[0]")
            value = Token("word", f"{numbered}[{value.value:g}]", value.text_of, value.start, 0)
        name = value.text if isinstance(value, Token) else numbered
        if name in ("$nullframe", "$world"):
            return Frame(name)
        known = not isinstance(value, Token) or name in self.data
        return Frame(name, self._aim(value).pose if known else None)

    def move(self, first: Token) -> list[Statement]:
        cursor, joint = self.cursor, first.text == "ptp"
        to = [self._target()]
        if first.text == "circ":
            cursor.expect(",")
            to.append(self._target())
        percent = joint and cursor.has("c_ptp")
        blended = cursor.has("c_dis") and not percent
        cursor.has("c_dis")  # inline forms write it twice, for what may come next

        def how() -> tuple[Speed, float]:
            if joint:
                speed = Speed(share=self._given("$vel_axis", 100.0) / 100.0)
            else:
                speed = Speed(path=self._given("$vel.cp"))
            exact = not blended or self._given("$advance", 3.0) == 0.0
            return speed, 0.0 if exact else MM * self._given("$apo.cdis")

        return [self.moving(first, to, how)]

    def _given(self, name: str, default: float | None = None) -> float:
        if isinstance(value := self.data.get(name), Number):
            return value.value
        if default is None:
            raise ValueError(f"{name.upper()} is not set before it")
        return default

    def _target(self) -> End:
        """Position or axes; P:{X ..} is an offset in the axes of P."""
        given = self._value()
        by = self.cursor.value("{}") if self.cursor.has(":") else None
        return partial(self._end, given, by)

    def _end(self, given: Value, by: Value | None) -> Aim | Target:
        if "a1" in self._fields(given, ()):
            angles = self._fields(given, AXES)
            return Target(motors=tuple(np.radians([self.number(angles[n]).value for n in AXES])))
        aim = self._aim(given)
        if by is None:
            return aim
        offset = {"a": 0.0, "b": 0.0, "c": 0.0}
        offset |= {k: self.number(v).value for k, v in self._fields(by, POSE[:3]).items()}
        if any(offset[n] != 0.0 for n in "abc"):
            self.refuse(by, "an offset must not turn")
        return aim.moved(aim.pose[:3, :3] @ [MM * offset[n] for n in "xyz"])

    def _aim(self, given: Value) -> Aim:
        fields = self._fields(given, POSE)
        x, y, z, *angles = (self.number(fields[n]) for n in POSE)
        R = from_roll_pitch_yaw(np.radians([number.value for number in angles]))
        external = tuple(self.number(fields[n]) for n in sorted(fields) if n.startswith("e"))
        return Aim.of((x, y, z), to_quaternion(R), MM, external)

    def _fields(self, given: Value, needed: Sequence[str]) -> dict[str, Value]:
        """Fields of a value in braces, or of a name for it."""
        value = self.named(given)
        if not isinstance(value, Group):
            self.refuse(given, "a value in braces is expected")
        fields = dict(zip(value.names, value.items, strict=True))
        if missing := [n.upper() for n in needed if n not in fields]:
            self.refuse(value, f"{', '.join(missing)} must be given")
        return fields
