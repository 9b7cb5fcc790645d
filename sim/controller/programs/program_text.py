"""A program in a person's own files: its moves, and the places of the numbers that may change."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion

from ...motion.instructions import Program, Target
from .scanner import Number, Text

Language = Literal["rapid", "krl", "urscript"]
UNIT = {"rapid": 1e-3, "krl": 1e-3, "urscript": 1.0}
"""Of lengths [m]."""
DECIMALS = {"rapid": 4, "krl": 4, "urscript": 7}
"""Least decimals of a length that is written: 0.1 um, as single precision has it at 1 m. With 1 um
tools were off by 5 um."""
LARGEST_POSITION = 100.0
"""[m]."""
Point = tuple[Number, ...]
"""The numbers x, y, z of a target."""


@dataclass(frozen=True, eq=False)
class Frame:
    """Tool in the flange, or work object (KRL: base) in the robot's base."""

    name: str
    pose: Array | None = field(default_factory=lambda: np.eye(4))
    """(4, 4) [m]; None where the file does not give it."""

    def same(self, other: "Frame") -> bool:
        """The same name and pose."""
        a, b = self.pose, other.pose
        alike = a is b if a is None or b is None else np.array_equal(a, b)
        return self.name == other.name and alike


@dataclass(frozen=True, kw_only=True)
class Aim:
    """Pose that a move goes to, with the numbers that give it."""

    target: Target
    """Offsets included."""
    point: Point
    external: tuple[float, ...] = ()
    """External axes, in the file's units."""
    base: Frame | None = None
    """URScript: feature that pose_trans refers it to."""

    @classmethod
    def of(cls, point: Point, quaternion: ArrayLike, unit: float, external: Point = ()) -> "Aim":
        """Of numbers in a unit [m]. Raises ProgramError for a position far away."""
        for number in point:
            if abs(number.value) * unit > LARGEST_POSITION:
                far = f"positions are at most {LARGEST_POSITION:g} m away"
                number.text_of.fail(number.start, far)
        x, y, z = (number.value * unit for number in point)
        w, i, j, k = map(float, np.asarray(quaternion))
        target = Target(position=(x, y, z), quaternion=(w, i, j, k))
        return cls(target=target, point=point, external=tuple(n.value for n in external))

    @property
    def pose(self) -> Array:
        """(4, 4)."""
        assert self.target.quaternion is not None
        return transform(from_quaternion(self.target.quaternion), np.array(self.target.position))

    def moved(self, by: ArrayLike) -> "Aim":
        """With an offset (3,) [m]."""
        x, y, z = map(float, self.pose[:3, 3] + np.asarray(by))
        return replace(self, target=replace(self.target, position=(x, y, z)))


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where an instruction stands, and what it refers to."""

    text: Text = field(repr=False)
    at: int
    aim: Aim | None = None
    """None of a wait, and of a move to joint angles."""
    tool: Frame = Frame("flange")
    base: Frame = Frame("base")


@dataclass(frozen=True, kw_only=True)
class ProgramText:
    """Program with its files; its positions are those of the tool in the move's work object."""

    language: Language
    texts: tuple[Text, ...] = field(repr=False)
    program: Program = field(repr=False)
    places: tuple[Place, ...] = field(repr=False)
    """Of each instruction."""
    entry: str
    """Routine that it starts with."""

    def edited(self, moves: Mapping[Point, Array]) -> tuple[Text, ...]:
        """The texts with points moved by (3,) [m] in their work object, every other byte as it
        is."""
        steps = {n: step for point, by in moves.items() for n, step in zip(point, by, strict=True)}
        found = list[Text]()
        for text in self.texts:
            pieces, at = list[str](), 0
            for n in sorted((n for n in steps if n.text_of is text), key=lambda n: n.start):
                pieces += [text.content[at : n.start], self.written(n, steps[n])]
                at = n.end
            found.append(Text(text.name, "".join(pieces) + text.content[at:]))
        return tuple(found)

    def edits(self, point: Point, by: Array) -> bool:
        """Moving a point by (3,) [m] changes a digit."""
        pairs = zip(point, by, strict=True)
        return any(self.written(n, step) != self.written(n, 0.0) for n, step in pairs)

    def written(self, number: Number, step: float) -> str:
        """A number with a step [m] added; as it was where its digits are the same."""
        old = number.text_of.content[number.start : number.end]
        fraction = old.partition(".")[2]
        n = max(DECIMALS[self.language], len(fraction) if fraction.isdigit() else 0)
        new = f"{number.value + step / UNIT[self.language]:.{n}f}"
        if float(new) == float(f"{number.value:.{n}f}"):
            return old
        new = new if float(new) else new.removeprefix("-")
        glued = number.text_of.content[number.start - 1 : number.start].isalnum()
        return f" {new}" if glued and new[0] != "-" else new  # X-1 would become the name X1
