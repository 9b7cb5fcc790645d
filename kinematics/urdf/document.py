"""Elements of a URDF file.

A document is read as UTF-8 text of bounded size, without a document type and so without entities.
"""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from .elements import Document, Fault, Inertial
from .inertial_element import inertial_of
from .joint_element import joint_of

LARGEST = 10_000_000
"""Bytes of a URDF file; those of large robots have some hundred thousand."""


def read_document(file: Path) -> Document:
    """Elements of a file; faults of single inertials and joints are kept with them.

    Raises:
        ValueError: the file is damaged; says which element is wrong and what is allowed.
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
    links: dict[str, Inertial | Fault | None] = {}
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
