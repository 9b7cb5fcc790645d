"""Elements of a URDF file, each checked on its own.

A document is read as UTF-8 text of bounded size, without a document type and so without entities.
"""

from collections.abc import Collection, Iterator
from math import inf
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from armside.arrays import Array

from ..equations.inertial_model import Body
from ..rotation import from_roll_pitch_yaw
from .links_and_joints import WHOLE_TURN, Document, Fault, Inertial, Kind, UrdfJoint

_HUGE = 1e6  # greatest number that is accepted, in any unit
ORIGIN, X_AXIS = np.zeros(3), np.array([1.0, 0.0, 0.0])
"""Values of attributes that are not there."""
ORIGIN.flags.writeable = X_AXIS.flags.writeable = False


def transform(where: str, element: Element) -> Array:
    """T (4, 4) of <origin>: rpy are rotations about the fixed axes x, y, z."""
    T = np.eye(4)
    roll, pitch, yaw = vector(where, element, "origin", "rpy", ORIGIN)
    T[:3, :3] = from_roll_pitch_yaw([yaw, pitch, roll])
    T[:3, 3] = vector(where, element, "origin", "xyz", ORIGIN)
    return T


def vector(where: str, element: Element, tag: str, name: str, default: Array) -> Array:
    """Three numbers (3,) of an attribute of a child, or the default where it is not there."""
    text = attribute(element, tag, name)
    if text is None:
        return default
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


def inertial_of(where: str, element: Element | None) -> Inertial | None:
    """Mass properties of a link, None where it has none, or zeros. ValueError names the link."""
    if element is None:
        return None
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = [attribute(element, "inertia", name) or 0.0 for name in names]
    inertia = [number(f"{where}: {n}", v) for n, v in zip(names, values, strict=True)]
    mass = number(f"{where}: mass", attribute(element, "mass", "value"))
    if mass == 0 and not any(inertia):
        return None
    if mass <= 0:
        raise ValueError(f"{where}: mass must be > 0 kg, got {mass:g}")
    try:
        body = Body(mass=mass, inertia=(*inertia,))  # pyright: ignore[reportArgumentType]
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    return Inertial(transform(where, element), body)


def joint_of(element: Element, name: str, links: Collection[str]) -> UrdfJoint:
    """A joint between two of the links; wrong numbers are its fault, wrong ends a ValueError."""
    where, given, ends = f"joint {name!r}", element.get("type", ""), list[str]()
    if given not in (allowed := [kind.value for kind in Kind if kind is not Kind.BALL]):
        raise ValueError(f"{where}: type must be one of {', '.join(allowed)}, got {given!r}")
    for tag in ("parent", "child"):
        if (link := attribute(element, tag, "link")) not in links:
            raise ValueError(f"{where}: {tag} link {link!r} is not in the file")
        ends.append(str(link))
    kind, mimic = Kind(given), element.find("mimic")
    mimics = None if mimic is None else mimic.get("joint", "")
    try:
        origin, axis = transform(where, element), _axis(where, kind, element)
        reach, speed = _range(where, kind, element), _speed(where, kind, element)
    except ValueError as error:
        nowhere = np.eye(4), X_AXIS, (-inf, inf), None
        return UrdfJoint(name, kind, ends[0], ends[1], *nowhere, mimics, str(error))
    return UrdfJoint(name, kind, ends[0], ends[1], origin, axis, reach, speed, mimics)


def _axis(where: str, kind: Kind, element: Element) -> Array:
    """Unit vector (3,); that of a joint without an axis is not read."""
    if kind in (Kind.FIXED, Kind.FLOATING):
        return X_AXIS
    axis = vector(where, element, "axis", "xyz", X_AXIS)
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise ValueError(f"{where}: axis must not be zero, got {axis.tolist()}")
    return axis / length


def _speed(where: str, kind: Kind, element: Element) -> float | None:
    """None where it is absent, or 0 as in files whose author had none."""
    if kind is Kind.FIXED:
        return None
    speed = number(f"{where}: limit velocity", attribute(element, "limit", "velocity") or 0.0)
    if speed < 0:
        raise ValueError(f"{where}: limit velocity must be >= 0, got {speed:g}")
    return speed or None


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


LARGEST = 10_000_000
"""Bytes of a URDF file; those of large robots have some hundred thousand."""


def read_document(file: Path) -> Document:
    """Elements of a file; faults of single inertials and joints are kept with them.

    Raises OSError, or ValueError for a damaged file: which element is wrong and what is allowed.
    """
    if file.exists() and not file.is_file():
        raise ValueError("is no regular file")
    with file.open("rb") as opened:
        text = opened.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise ValueError(f"a URDF file has at most {LARGEST} bytes")
    content = text.decode("utf-8-sig")
    if "<!DOCTYPE" in content or "<!ENTITY" in content:
        raise ValueError("a URDF file has no document type and no entities")
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise ValueError(f"damaged XML: {error}") from None
    if root.tag != "robot":
        raise ValueError(f"the outermost element must be <robot>, got <{root.tag}>")
    if any("xacro" in str(element.tag) for element in root.iter()):
        raise ValueError("has xacro elements: expand it first (ros2 run xacro xacro FILE)")
    links = dict[str, Inertial | Fault | None]()
    for element, name in _named(root, "link"):
        try:
            links[name] = inertial_of(f"link {name!r}", element.find("inertial"))
        except ValueError as error:
            links[name] = Fault(str(error))
    joints = tuple(joint_of(element, name, links) for element, name in _named(root, "joint"))
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
