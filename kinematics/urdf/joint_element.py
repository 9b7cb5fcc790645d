"""Joint elements of a URDF file, each checked on its own."""

from collections.abc import Collection
from math import inf, pi
from xml.etree.ElementTree import Element

import numpy as np

from armside.arrays import Array

from .elements import WHOLE_TURN, Kind, UrdfJoint
from .values import attribute, number, transform, vector


def joint_of(element: Element, name: str, links: Collection[str]) -> UrdfJoint:
    """A joint between two of the links.

    Raises:
        ValueError: names the joint, what is wrong and what is allowed.
    """
    where, given = f"joint {name!r}", element.get("type", "")
    if given not in (allowed := [kind.value for kind in Kind]):
        raise ValueError(f"{where}: type must be one of {', '.join(allowed)}, got {given!r}")
    kind, mimic = Kind(given), element.find("mimic")
    parent, child = (_end(where, element, tag, links) for tag in ("parent", "child"))
    return UrdfJoint(
        name=name,
        kind=kind,
        parent=parent,
        child=child,
        origin=transform(where, element),
        axis=_axis(where, element),
        range=_range(where, kind, element),
        speed=_speed(where, kind, element),
        mimics=None if mimic is None else mimic.get("joint", ""),
    )


def _end(where: str, element: Element, tag: str, links: Collection[str]) -> str:
    link = attribute(element, tag, "link")
    if link not in links:
        raise ValueError(f"{where}: {tag} link {link!r} is not in the file")
    return str(link)


def _axis(where: str, element: Element) -> Array:
    axis = vector(where, element, "axis", "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise ValueError(f"{where}: axis must not be zero, got {axis.tolist()}")
    return axis / length


def _speed(where: str, kind: Kind, element: Element) -> float:
    speed = number(f"{where}: limit velocity", attribute(element, "limit", "velocity") or pi)
    if kind is not Kind.FIXED and speed <= 0:
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
