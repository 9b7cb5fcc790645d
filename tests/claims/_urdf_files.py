"""URDF files that others wrote, found in installed packages of data, and Pinocchio's reading."""

# pyright: reportMissingImports=false

from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from armside.arrays import Array
from armside.kinematics.urdf.document import read_document
from armside.kinematics.urdf.links_and_joints import Document, Kind, children

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


class PinocchioChain:
    """A chain of a file, from its root link to a tip, by the names of its joints.

    Raises ImportError without Pinocchio, and ValueError where Pinocchio does not read the file.
    """

    def __init__(self, file: Path, joints: Sequence[str], tip: str) -> None:
        import pinocchio as pin

        self._pin: Any = pin
        self._model = pin.buildModelFromUrdf(str(file))
        self._data = self._model.createData()
        missing = [name for name in (*joints, tip) if not self._model.existFrame(name)]
        if missing:
            raise ValueError(f"Pinocchio has no {missing[0]}")
        self._joints = [self._model.joints[self._model.getJointId(name)] for name in joints]
        self._columns = [joint.idx_v for joint in self._joints]
        self._tip = self._model.getFrameId(tip, pin.FrameType.BODY)

    def at(self, values: Array) -> tuple[Array, Array, Array]:
        """T_root_tip (4, 4), (v, omega) of the tip (6, n) and mass matrix (n, n) at joint values.

        Joints beside the chain stand at zero.
        """
        pin, model, data = self._pin, self._model, self._data
        q = pin.neutral(model)
        for joint, value in zip(self._joints, values, strict=True):
            both = (np.cos(value), np.sin(value))  # a continuous joint has two
            q[joint.idx_q : joint.idx_q + joint.nq] = both if joint.nq == 2 else value
        pin.framesForwardKinematics(model, data, q)
        T = np.array(data.oMf[self._tip].homogeneous)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = np.array(pin.computeFrameJacobian(model, data, q, self._tip, axes))
        upper = np.triu(pin.crba(model, data, q))
        D = upper + np.triu(upper, 1).T
        return T, J[:, self._columns], D[np.ix_(self._columns, self._columns)]
