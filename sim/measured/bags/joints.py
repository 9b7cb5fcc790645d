"""Order of the joints that a bag names, as the motors of a robot."""

import re
from collections.abc import Sequence

from ...records.files import InputError

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
