"""Arrays of a bag's samples, by the stamps of the headers."""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ...records.files import InputError
from .messages import BILLION, Joints, Sample
from .topics import FRAME

UR = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
"""Parts of the names of Universal Robots' joints, from the base on; their driver publishes them in
the order of the alphabet."""
NUMBERED = re.compile(r"(.*?)(\d+)(\D*)")


def joint_order(topic: str, names: Sequence[str], asked: Sequence[str]) -> tuple[str, ...]:
    """Names of the joints from the base on.

    Those asked for; or else names that differ in one number alone, by that; or those of Universal
    Robots.

    Raises:
        InputError: a joint is not there, or the names have no order.
    """
    listed = ", ".join(names) or "no names"
    if asked:
        if absent := [name for name in asked if name not in names]:
            raise InputError(f"{topic} has no joint {absent[0]}. Joints: {listed}")
        return tuple(asked)
    if len(set(names)) == len(names) > 0:
        if found := _by_number(names) or _of_ur(names):
            return found
        if len(names) == 1:
            return tuple(names)
    raise InputError(f"the joints of {topic} have no order by name ({listed}): give --joints")


def _by_number(names: Sequence[str]) -> tuple[str, ...]:
    """Names that differ in their last number alone, by that; or none."""
    found = [NUMBERED.fullmatch(name) for name in names]
    parts = [match.groups() for match in found if match]
    around = {(head, tail) for head, _, tail in parts}
    numbers = {int(number): name for (_, number, _), name in zip(parts, names, strict=False)}
    if len(parts) != len(names) or len(around) != 1 or len(numbers) != len(names):
        return ()
    return tuple(numbers[number] for number in sorted(numbers))


def _of_ur(names: Sequence[str]) -> tuple[str, ...]:
    own = [[name for name in names if f"{part}_joint" in name] for part in UR]
    if len(names) != len(UR) or any(len(one) != 1 for one in own):
        return ()
    return tuple(one[0] for one in own)


FEW = 0.5
"""Fraction of the messages that may lack joints before the topic is refused."""


class Stamped(NamedTuple):
    """Samples by the stamps of their headers."""

    stamp: NDArray[np.int64]
    """(N,) [ns]."""
    values: Array
    """(N, m)."""

    def time(self, origin: int) -> Array:
        """(N,) [s] from an origin [ns], exact to the nanosecond for a century."""
        whole, part = np.divmod(self.stamp - origin, BILLION)
        return whole + part / BILLION


def encoders(
    topic: str, messages: list[Joints], asked: tuple[str, ...]
) -> tuple[Stamped, tuple[str, ...]]:
    """Angles in the order of the motors, and notes: order of the joints, messages left out.

    Raises InputError for joints without an order, and messages without angles or stamps.
    """
    names = tuple(dict.fromkeys(name for one in messages for name in one.names))
    order = joint_order(topic, names, asked)
    rows, stamps = [], []
    places: dict[tuple[str, ...], list[int] | None] = {}
    for one in messages:
        if one.names not in places:
            whole = set(order) <= set(one.names)
            places[one.names] = [one.names.index(name) for name in order] if whole else None
        place = places[one.names]
        if place is not None and len(one.position) == len(one.names):
            rows.append(one.position[place])
            stamps.append(one.stamp)
    if len(rows) <= FEW * len(messages):
        text = f"{len(messages) - len(rows)} of {len(messages)} messages lack positions of some of"
        raise InputError(f"{topic}: {text} {', '.join(order)}: choose others by --joints")
    notes = [f"encoders: {topic}, joints {', '.join(order)}"]
    if left := len(messages) - len(rows):
        notes.append(f"encoders: {left} messages without all of these joints are left out")
    return _stamped(topic, stamps, np.array(rows)), tuple(notes)


def sensor(topic: str, found: list[Sample]) -> tuple[Stamped, tuple[str, ...]]:
    """Samples of an IMU or a target, and a note of its frames.

    Raises InputError for samples of several frames, or without stamps.
    """
    children = sorted({one.child for one in found})
    if len(children) > 1:
        text = f"measures {len(children)} frames: {', '.join(children)}"
        raise InputError(f"{topic} {text}; choose one as {topic}{FRAME}{children[0]}")
    frames = sorted({one.frame for one in found})
    if len(frames) > 1:
        raise InputError(f"{topic} gives its values in {len(frames)} frames: {', '.join(frames)}")
    values = np.array([one.values for one in found], dtype=np.float64)
    said = f"{topic}, frame {frames[0] or 'without a name'}"
    return _stamped(topic, [one.stamp for one in found], values), (said,)


def _stamped(topic: str, stamps: list[int], values: Array) -> Stamped:
    if not any(stamps):
        raise InputError(f"{topic}: the headers carry no stamps (all are zero)")
    return Stamped(np.array(stamps, dtype=np.int64), values)
