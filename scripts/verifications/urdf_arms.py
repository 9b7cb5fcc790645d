"""URDF files that others wrote, found in installed packages of data, and the arm in each."""

from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from armside.kinematics.urdf.chain import Document, Kind, children
from armside.kinematics.urdf.document import read_document

PACKAGES = ("rtb-data", "example-robot-data", "pybullet", "robosuite")
"""Distributions with URDF files; those that are not installed are left out."""
LEAST_JOINTS = 4
"""Moving joints in a row from which on a chain counts as an arm; legs of most walkers have 3."""
_OBJECTS = "random_urdfs"  # a thousand things to grasp, without joints


class ForeignFile(NamedTuple):
    """A URDF file, the distribution and version that it is from, and the end of its path there."""

    package: str
    name: str
    path: Path


def foreign_files() -> list[ForeignFile]:
    """URDF files of the installed packages."""
    found = list[ForeignFile]()
    for package in PACKAGES:
        try:
            files = metadata.files(package) or []
        except metadata.PackageNotFoundError:
            continue
        for file in sorted(map(str, files)):
            if file.endswith(".urdf") and _OBJECTS not in file:
                place = Path(str(metadata.distribution(package).locate_file(file)))
                source = f"{package} {metadata.version(package)}"
                found.append(ForeignFile(source, _short(file), place))
    return found


def longest_chain(path: Path) -> tuple[str, int]:
    """Tip of the chain with most moving joints, and their number; the first of equals.

    Raises ValueError where the file is damaged.
    """
    document = read_document(path)
    below, best = children(document), ("", 0)
    ends = [(root, 0) for root in _roots(document)]
    while ends:
        link, count = ends.pop(0)
        if count > best[1]:
            best = link, count
        for joint in below[link]:
            ends.append((joint.child, count + (joint.kind is not Kind.FIXED)))
    return _last_fixed(document, best[0]), best[1]


def _roots(document: Document) -> list[str]:
    held = {joint.child for joint in document.joints}
    return [link for link in document.links if link not in held]


def _last_fixed(document: Document, link: str) -> str:
    """The end of what is fixed to a link, one after the other: a flange, a tool."""
    below = children(document)
    while len(below[link]) == 1 and below[link][0].kind is Kind.FIXED:
        link = below[link][0].child
    return link


def _short(file: str) -> str:
    """The last two folders and the name."""
    return "/".join(Path(file).parts[-3:])
