"""Joint elements of a URDF file, each checked on its own."""

from collections.abc import Collection
from math import inf, pi
from xml.etree.ElementTree import Element

import numpy as np

from armside.arrays import Array

from .elements import WHOLE_TURN, Kind, UrdfJoint
from .values import attribute, number, transform, vector


def joint_of(element: Element, name: str, links: Collection[str]) -> UrdfJoint:
    """A joint between two of the links; wrong numbers are its fault.

    Raises:
        ValueError: its type or its ends are wrong; names the joint and what is allowed.
    """
    where, given = f"joint {name!r}", element.get("type", "")
    if given not in (allowed := [kind.value for kind in Kind if kind is not Kind.BALL]):
        raise ValueError(f"{where}: type must be one of {', '.join(allowed)}, got {given!r}")
    kind, mimic = Kind(given), element.find("mimic")
    parent, child = (_end(where, element, tag, links) for tag in ("parent", "child"))
    mimics = None if mimic is None else mimic.get("joint", "")
    try:
        numbers = _numbers(where, kind, element)
    except ValueError as error:
        nowhere = np.eye(4), np.array([1.0, 0.0, 0.0]), (-inf, inf), pi
        return UrdfJoint(name, kind, parent, child, *nowhere, mimics, str(error))
    return UrdfJoint(name, kind, parent, child, *numbers, mimics)


def _numbers(
    where: str, kind: Kind, element: Element
) -> tuple[Array, Array, tuple[float, float], float]:
    """Origin, axis, range and greatest speed."""
    origin, axis = transform(where, element), _axis(where, kind, element)
    return origin, axis, _range(where, kind, element), _speed(where, kind, element)


def _end(where: str, element: Element, tag: str, links: Collection[str]) -> str:
    link = attribute(element, tag, "link")
    if link not in links:
        raise ValueError(f"{where}: {tag} link {link!r} is not in the file")
    return str(link)


def _axis(where: str, kind: Kind, element: Element) -> Array:
    """Unit vector (3,); that of a joint without an axis is not read."""
    if kind in (Kind.FIXED, Kind.FLOATING):
        return np.array([1.0, 0.0, 0.0])
    axis = vector(where, element, "axis", "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise ValueError(f"{where}: axis must not be zero, got {axis.tolist()}")
    return axis / length


def _speed(where: str, kind: Kind, element: Element) -> float:
    if kind is Kind.FIXED:
        return pi
    speed = number(f"{where}: limit velocity", attribute(element, "limit", "velocity") or pi)
    if speed <= 0:
        raise ValueError(f"{where}: limit velocity must be > 0, got {speed:g}")
    return speed


def _range(where: str, kind: Kind, element: Element) -> tuple[float, float]:
    if kind is Kind.CONTINUOUS:
        return -WHOLE_TURN, WHOLE_TURN
    if kind not in (Kind.REVOLUTE, Kind.PRISMATIC):
        return -inf, inf
    if element.find("limit") is None:
        raise ValueError(f"{where}: a {kind.value} joint needs <limit lower upper velocity>")
    lower, upper = (
        number(f"{where}: limit {end}", attribute(element, "limit", end) or 0.0)
        for end in ("lower", "upper")
    )
    if not lower < upper:
        raise ValueError(f"{where}: limit lower must be below upper, got {lower:g} and {upper:g}")
    return lower, upper
