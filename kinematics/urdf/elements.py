"""Links and joints of a URDF file, each checked on its own.

A document is read as UTF-8 text of bounded size, without a document type and so without entities.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from math import inf, pi
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from armside.arrays import Array

from ..equations.inertial_model import Body
from ..rotation import from_roll_pitch_yaw

LARGEST = 10_000_000
"""Bytes of a URDF file; those of large robots have some hundred thousand."""
_HUGE = 1e6  # greatest number that is accepted, in any unit
_TURN = 2 * pi


class Kind(Enum):
    """Types of joint that URDF knows; the last two have more than one degree of freedom."""

    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    FIXED = "fixed"
    FLOATING = "floating"
    PLANAR = "planar"


@dataclass(frozen=True)
class UrdfJoint:
    """A joint; its frame is at `origin` (4, 4) in the parent's, its axis (3,) is in its own."""

    name: str
    kind: Kind
    parent: str
    child: str
    origin: Array
    axis: Array
    range: tuple[float, float]
    """[rad or m]; a whole turn to either side for a continuous joint."""
    speed: float
    """[rad/s or m/s]; pi where the file has none, as in a robot file."""
    mimics: str | None


@dataclass(frozen=True)
class Inertial:
    """Mass properties of a link: a body in axes at `origin` (4, 4) of the link's frame."""

    origin: Array
    body: Body


@dataclass(frozen=True)
class Document:
    """Name of the robot; inertial of each link, None where it has none; joints in file order."""

    name: str
    links: dict[str, Inertial | None]
    joints: tuple[UrdfJoint, ...]


def read_document(file: Path) -> Document:
    """Elements of a file.

    Raises:
        ValueError: says which element is wrong and what is allowed.
        OSError: the file cannot be read.
    """
    if file.exists() and not file.is_file():
        raise ValueError("is no regular file")
    with file.open("rb") as content:
        text = content.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise ValueError(f"a URDF file has at most {LARGEST} bytes")
    return _document(_root(text.decode("utf-8-sig")))


def _root(text: str) -> Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise ValueError("a URDF file has no document type and no entities")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"damaged XML: {error}") from None
    if root.tag != "robot":
        raise ValueError(f"the outermost element must be <robot>, got <{root.tag}>")
    if any("xacro" in str(element.tag) for element in root.iter()):
        raise ValueError("has xacro elements: expand it first (ros2 run xacro xacro FILE)")
    return root


def _document(root: Element) -> Document:
    links: dict[str, Inertial | None] = {}
    for element, name in _named(root, "link"):
        links[name] = _inertial(f"link {name!r}", element.find("inertial"))
    joints = tuple(_joint(element, name, links) for element, name in _named(root, "joint"))
    if not links:
        raise ValueError("needs at least one <link>")
    name = " ".join(root.get("name", "robot").split())[:80]
    return Document(name if name and name.isprintable() else "robot", links, joints)


def _named(root: Element, tag: str) -> Iterator[tuple[Element, str]]:
    """Elements of a tag with their names, each of which is there once."""
    seen = set()
    for element in root.findall(tag):
        name = element.get("name", "")
        if not name or not name.isprintable():
            raise ValueError(f"each <{tag}> needs a name of printable text, got {name!r}")
        if name in seen:
            raise ValueError(f"{tag} {name!r} is there twice")
        seen.add(name)
        yield element, name


def _joint(element: Element, name: str, links: dict[str, Inertial | None]) -> UrdfJoint:
    where, given = f"joint {name!r}", element.get("type", "")
    if given not in (allowed := [kind.value for kind in Kind]):
        raise ValueError(f"{where}: type must be one of {', '.join(allowed)}, got {given!r}")
    ends = []
    for tag in ("parent", "child"):
        link = _attribute(element, tag, "link")
        if link not in links:
            raise ValueError(f"{where}: {tag} link {link!r} is not in the file")
        ends.append(link)
    kind, axis = Kind(given), _vector(where, element, "axis", "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise ValueError(f"{where}: axis must not be zero, got {axis.tolist()}")
    mimic = element.find("mimic")
    mimics = None if mimic is None else mimic.get("joint", "")
    bounds = _range(where, kind, element)
    speed = _number(f"{where}: limit velocity", _attribute(element, "limit", "velocity") or pi)
    if kind is not Kind.FIXED and speed <= 0:
        raise ValueError(f"{where}: limit velocity must be > 0, got {speed:g}")
    origin = _transform(where, element)
    return UrdfJoint(name, kind, ends[0], ends[1], origin, axis / length, bounds, speed, mimics)


def _range(where: str, kind: Kind, element: Element) -> tuple[float, float]:
    if kind is Kind.CONTINUOUS:
        return -_TURN, _TURN
    if kind not in (Kind.REVOLUTE, Kind.PRISMATIC):
        return -inf, inf
    if element.find("limit") is None:
        raise ValueError(f"{where}: a {kind.value} joint needs <limit lower upper velocity>")
    lower, upper = (
        _number(f"{where}: limit {end}", _attribute(element, "limit", end) or 0.0)
        for end in ("lower", "upper")
    )
    if not lower < upper:
        raise ValueError(f"{where}: limit lower must be below upper, got {lower:g} and {upper:g}")
    return lower, upper


def _inertial(where: str, element: Element | None) -> Inertial | None:
    if element is None:
        return None
    mass = _number(f"{where}: mass", _attribute(element, "mass", "value"))
    if mass <= 0:
        raise ValueError(f"{where}: mass must be > 0 kg, got {mass:g}")
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = [_attribute(element, "inertia", name) or 0.0 for name in names]
    inertia = [_number(f"{where}: {n}", v) for n, v in zip(names, values, strict=True)]
    try:
        body = Body(mass=mass, inertia=(*inertia,))  # pyright: ignore[reportArgumentType]
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    return Inertial(_transform(where, element), body)


def _transform(where: str, element: Element) -> Array:
    """T (4, 4) of <origin>: rpy are rotations about the fixed axes x, y, z."""
    T = np.eye(4)
    roll, pitch, yaw = _vector(where, element, "origin", "rpy", (0.0, 0.0, 0.0))
    T[:3, :3] = from_roll_pitch_yaw([yaw, pitch, roll])
    T[:3, 3] = _vector(where, element, "origin", "xyz", (0.0, 0.0, 0.0))
    return T


def _vector(
    where: str, element: Element, tag: str, name: str, default: tuple[float, float, float]
) -> Array:
    text = _attribute(element, tag, name)
    if text is None:
        return np.array(default)
    values = [_number(f"{where}: {tag} {name}", word) for word in text.split()]
    if len(values) != 3:
        raise ValueError(f"{where}: {tag} {name} must be three numbers, got {text[:60]!r}")
    return np.array(values)


def _attribute(element: Element, tag: str, name: str) -> str | None:
    child = element.find(tag)
    return None if child is None else child.get(name)


def _number(what: str, text: str | float | None) -> float:
    try:
        value = float("" if text is None else text)
    except ValueError:
        value = inf
    if not abs(value) <= _HUGE:
        raise ValueError(f"{what} must be a number up to {_HUGE:g}, got {str(text)[:40]!r}")
    return value
