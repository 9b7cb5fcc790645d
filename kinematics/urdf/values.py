"""Numbers, vectors and transforms in the attributes of a URDF file."""

from math import inf
from xml.etree.ElementTree import Element

import numpy as np

from armside.arrays import Array

from ..rotation import from_roll_pitch_yaw

_HUGE = 1e6  # greatest number that is accepted, in any unit


def transform(where: str, element: Element) -> Array:
    """T (4, 4) of <origin>: rpy are rotations about the fixed axes x, y, z."""
    T = np.eye(4)
    roll, pitch, yaw = vector(where, element, "origin", "rpy", (0.0, 0.0, 0.0))
    T[:3, :3] = from_roll_pitch_yaw([yaw, pitch, roll])
    T[:3, 3] = vector(where, element, "origin", "xyz", (0.0, 0.0, 0.0))
    return T


def vector(
    where: str, element: Element, tag: str, name: str, default: tuple[float, float, float]
) -> Array:
    """Three numbers (3,) of an attribute of a child, or the default where it is not there."""
    text = attribute(element, tag, name)
    if text is None:
        return np.array(default)
    values = [number(f"{where}: {tag} {name}", word) for word in text.split()]
    if len(values) != 3:
        raise ValueError(f"{where}: {tag} {name} must be three numbers, got {text[:60]!r}")
    return np.array(values)


def attribute(element: Element, tag: str, name: str) -> str | None:
    """Text of an attribute of a child, None where it is not there."""
    child = element.find(tag)
    return None if child is None else child.get(name)


def number(what: str, text: str | float | None) -> float:
    """A number of bounded size. Raises ValueError with what it is."""
    try:
        value = float("" if text is None else text)
    except ValueError:
        value = inf
    if not abs(value) <= _HUGE:
        raise ValueError(f"{what} must be a number up to {_HUGE:g}, got {str(text)[:40]!r}")
    return value
