"""URScript of Universal Robots: movel, movec, movej, movep, poses p[x, y, z, rx, ry, rz].

Conventions by "The URScript programming language": m, rad, rotation vector; v [m/s] of the tool,
[rad/s] in movej; r, the radius of a blend [m]. Blends must not overlap.
"""

from collections import ChainMap
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np

from armside.kinematics.rotation import from_axis_angle, to_quaternion

from ...motion.instructions import MoveC, MoveJ, MoveL, Speed, Target
from .program_text import Aim, Frame
from .reader import Reader, Statement
from .scanner import NUMBER, Group, Token, Value

ARGUMENTS = {"movel": "a v t r", "movej": "a v t r", "movep": "a v r", "movec": "a v r mode"}
"""After the targets, in their order."""
SPEED, JOINT_SPEED = 0.25, 1.05
"""v where it is not given [m/s], [rad/s], by the manual."""
HIGHEST = np.pi
"""Highest speed of a joint [rad/s]. ESTIMATE: 180 deg/s, as of the wrists."""
NO_TURN = 1e-12
COUNTER = (
    r"thread (?P<thread>Step_Counter_Thread_\w+)\(\):\s+while \(True\):\s+(?P<count>\w+) = "
    r"(?P=count) \+ 1(?:\.0)?\s+sync\(\)\s+end\s+end\s+run (?P=thread)\(\)"
)
"""PolyScope's own thread, which counts time and does nothing."""
Made = Callable[[], "Value | Aim"]


class UrScript(Reader):
    """Reader of a script: its lines, or the function that no other calls where it calls none."""

    language = "urscript"
    grammar = (
        rf"(?P<skip>[ \t\f]+|(?:#|\$ [0-9])[^\r\n]*|{COUNTER})|(?P<newline>\r?\n)|"
        + r"(?P<string>\"[^\"\r\n]*\")|"
        + NUMBER
        + r"|(?P<word>[A-Za-z_][A-Za-z_0-9]*)|(?P<sign>==|[\[\](),:{}+\-*/=<>?])"
    )
    fold: ClassVar[bool] = False
    end = ("newline",)
    routine, call, wait = ("def", "end"), ("(", ")"), ("sleep", "(")
    head = ("(", ")", ":")
    moves: ClassVar = {"movel": MoveL, "movep": MoveL, "movec": MoveC, "movej": MoveJ}
    unmoving = frozenset(
        [f"set_{kind}digital_out" for kind in ("", "standard_", "configurable_", "tool_")]
        + [f"set_{kind}analog_out" for kind in ("", "standard_")]
        + [f"set_{kind}_analog_input_domain" for kind in ("standard", "tool")]
        + [f"set_tool_{what}" for what in ("communication", "output_mode", "voltage")]
        + ["set_payload", "set_payload_mass", "set_payload_cog", "set_target_payload"]
        + ["set_tool_digital_output_mode", "set_analog_outputdomain", "set_gravity", "textmsg"]
        + ["set_input_actions_to_default", "set_safety_mode_transition_hardness"]
    )

    def file(self) -> list[Statement]:
        self.tool = Frame("the installation's TCP", None)
        self.shared = self.own = self.data
        return self.body("")

    def run(self, name: str, at: Token) -> None:
        """Carry out a function, which sees its own variables and the global ones; all variables of
        the program's first level are global."""
        outer = self.own, self.data
        self.own = {} if self.depth or self.shared else self.shared
        self.data = ChainMap(self.own, self.shared)
        super().run(name, at)
        self.own, self.data = outer

    def pass_over(self, first: Token) -> None:
        """Up to its bracket: another statement may follow in the line."""
        self.cursor.expect(first.text, "(")
        depth = 1
        while depth and not self.ends:
            text = self.cursor.take().text
            depth += (text == "(") - (text == ")")

    def declaration(self, first: Token) -> list[Statement]:
        cursor = self.cursor
        if cursor.has("set_tcp", "("):
            value = self._value()
            if cursor.has(","):
                cursor.has("tcp_name", "=")
                cursor.take("string")
            cursor.expect(")")
            return [lambda: self._set_tool(value(), first)]
        scope = next((word for word in ("global", "local") if cursor.has(word)), "")
        name = cursor.take("word").text
        if not cursor.has("="):
            cursor.fail(f"{first} is not understood", first)
        value = self._value()
        return [lambda: self._assign(name, value(), scope)]

    def _assign(self, name: str, value: "Value | Aim", scope: str) -> None:
        free = not scope and name not in self.own
        found = self.shared if scope == "global" or (free and name in self.shared) else self.own
        found[name] = value

    def _set_tool(self, given: "Value | Aim", at: Token) -> None:
        if (aim := self._aim(given, at)).base is not None:
            self.refuse(at, "a TCP in a feature is not understood")
        self.tool = Frame("the TCP that is set", aim.pose)

    def _value(self, depth: int = 0) -> Made:
        """Number, name, [joints], p[pose], pose_add(P, p[..]) or pose_trans(F, P)."""
        cursor, first = self.cursor, self.cursor.next
        if depth > 2:
            cursor.fail("functions are at most 2 deep")
        after = cursor.tokens[cursor.at + 1].text if first.kind == "word" else ""
        if after == "[" and cursor.has("p"):
            pose = cursor.value()
            return lambda: self._pose(pose)
        if after != "(":
            value, plain = cursor.value(), first.kind == "string" or first.text in ("True", "False")
            return lambda: value if plain else self.named(value)
        if first.text not in ("pose_add", "pose_trans"):
            cursor.fail(f"{first} is not understood", first)
        cursor.take()
        cursor.expect("(")
        left = self._value(depth + 1)
        cursor.expect(",")
        right = self._value(depth + 1)
        cursor.expect(")")
        return lambda: self._sum(first, self._aim(left(), first), self._aim(right(), first))

    def _pose(self, given: Value) -> Aim:
        assert isinstance(given, Group)
        numbers = given.numbers(6, "a pose")
        vector = np.array([number.value for number in numbers[3:]])
        angle = float(np.linalg.norm(vector))
        R = from_axis_angle(vector, angle) if angle else np.eye(3)
        return Aim.of(numbers[:3], to_quaternion(R), 1.0)

    def _sum(self, name: Token, a: Aim, b: Aim) -> Aim:
        if a.base is not None or b.base is not None:
            self.refuse(name, "a feature in a feature is not understood")
        if name.text == "pose_trans":
            return replace(b, base=Frame("the feature", a.pose))
        if np.abs(b.pose[:3, :3] - np.eye(3)).max() > NO_TURN:
            self.refuse(name, "an offset must not turn")
        return a.moved(b.pose[:3, 3])

    def move(self, first: Token) -> list[Statement]:
        cursor, names = self.cursor, ARGUMENTS[first.text].split()
        cursor.expect("(")
        inverse = first.text == "movej" and cursor.has("get_inverse_kin", "(")
        to, given = [partial(self._end, self._value(), first)], dict[str, Made]()
        if inverse:  # which of the solutions is left to the controller
            if cursor.has(","):
                cursor.has("qnear", "=")
                self._value()
            cursor.expect(")")
        if first.text == "movec":
            cursor.expect(",")
            to.append(partial(self._end, self._value(), first))
        while cursor.has(","):
            free = [name for name in names if name not in given]
            named = cursor.tokens[cursor.at + 1].text == "="
            key = cursor.next.text if named else "".join(free[:1])
            if key not in free:
                cursor.fail(f"{first} has {', '.join(names)}, each once")
            cursor.has(key, "=")
            given[key] = self._value()
        cursor.expect(")")

        def how() -> tuple[Speed, float]:
            values = {name: self.number(value(), first).value for name, value in given.items()}
            if values.get("t"):
                self.refuse(first, "a time in place of a speed is not understood")
            zone = values.get("r", 0.0)
            if first.text == "movej":
                return Speed(share=min(values.get("v", JOINT_SPEED) / HIGHEST, 1.0)), zone
            return Speed(path=values.get("v", SPEED)), zone

        return [self.moving(first, to, how)]

    def _end(self, value: Made, at: Token) -> Aim | Target:
        given = value()
        if at.text != "movej" or not isinstance(given, Group):
            return self._aim(given, at)
        return Target(motors=tuple(n.value for n in given.numbers(6, "joint angles")))

    def _aim(self, value: "Value | Aim", at: Token) -> Aim:
        if not isinstance(value, Aim):
            self.refuse(at, f"{at} needs a pose p[...]")
        return value
