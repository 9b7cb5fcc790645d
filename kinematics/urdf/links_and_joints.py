"""Links and joints of a file of an arm, whatever its format, and the chain from base to tip."""

from collections import defaultdict
from dataclasses import dataclass
from enum import Enum
from math import pi

import numpy as np

from armside.arrays import Array

from .. import rigid
from ..equations.inertial_model import PLACES, Body, tensor_of

WHOLE_TURN = 2 * pi
"""[rad], range of a continuous joint to either side."""


class Kind(Enum):
    """Types of joint; the last three have more than one degree of freedom. Only MJCF has balls."""

    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    FIXED = "fixed"
    FLOATING = "floating"
    PLANAR = "planar"
    BALL = "ball"


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
    speed: float | None
    """[rad/s or m/s]; None where the file has none."""
    mimics: str | None
    fault: str | None = None
    """What is wrong with it; a chain without the joint may be used all the same."""


@dataclass(frozen=True)
class Inertial:
    """Mass properties of a link: a body in axes at `origin` (4, 4) of the link's frame."""

    origin: Array
    body: Body


@dataclass(frozen=True)
class Fault:
    """Sentence on what is wrong with the inertial of a link; an arm that it moves is refused."""

    sentence: str


@dataclass(frozen=True)
class Document:
    """Name of the robot; inertial of each link, None where it has none; joints in file order."""

    name: str
    links: dict[str, Inertial | Fault | None]
    joints: tuple[UrdfJoint, ...]


TOOL = "tool0"
"""Link or site that is the tip by default: the tool's frame by the convention of ROS-Industrial."""
_MOST_NAMES = 12  # tips that a message lists


def chain(document: Document, base: str | None, tip: str | None) -> tuple[UrdfJoint, ...]:
    """Joints from the base to the tip; by default from the root to `tool0` or the only end of the
    tree that moves.

    Raises ValueError: the file is no tree, the links are not on one branch, several branches and no
    tip, a joint on the chain that a serial arm cannot have, or none that moves.
    """
    parents = _parents(document)
    for end in filter(None, (base, tip)):
        if end not in document.links:
            raise ValueError(f"link {end!r} is not in the file; links: {_listed(document.links)}")
    roots = [link for link in document.links if link not in parents]
    if len(roots) > 1:
        raise ValueError(f"must have one link without a parent, got {_listed(roots)}")
    first = base or roots[0]
    tip = tip or _only_end(document, first)
    joints, link = [], tip
    while link != first:
        if link not in parents:
            raise ValueError(f"no chain leads from link {base!r} to link {tip!r}")
        joints.append(parents[link])
        link = parents[link].parent
    joints.reverse()
    for joint in joints:
        _check(joint)
    if all(joint.kind is Kind.FIXED for joint in joints):
        raise ValueError(f"no joint moves between link {link!r} and link {tip!r}")
    return tuple(joints)


def children(document: Document) -> dict[str, list[UrdfJoint]]:
    """Joints by the name of their parent link."""
    found = defaultdict(list)
    for joint in document.joints:
        found[joint.parent].append(joint)
    return found


def _parents(document: Document) -> dict[str, UrdfJoint]:
    """Joint by the name of its child link; every link has one parent at most, and no loop."""
    parents: dict[str, UrdfJoint] = {}
    for joint in document.joints:
        if joint.child in parents:
            other = parents[joint.child].name
            raise ValueError(f"link {joint.child!r} closes a loop: {other!r} and {joint.name!r}")
        parents[joint.child] = joint
    for start in document.links:
        link, steps = start, 0
        while link in parents:
            link, steps = parents[link].parent, steps + 1
            if steps > len(parents):
                raise ValueError(f"link {start!r} is in a loop: it is below itself")
    return parents


def _only_end(document: Document, base: str) -> str:
    below, ends, links = children(document), [], [(base, False)]
    while links:
        link, moves = links.pop()
        if not below[link]:
            ends.append((link, moves))
        links += [(joint.child, moves or joint.kind is not Kind.FIXED) for joint in below[link]]
    if len(ends) > 1:
        ends = [end for end in ends if end[1]] or ends
    names = [link for link, _ in ends]
    if TOOL in names:
        return TOOL
    if len(names) > 1:
        how = "`robot new --tip TIP`, elsewhere FILE#TIP"
        found = _listed(sorted(names))
        raise ValueError(f"has several branches; choose a tip link, by {how}: {found}")
    return names[0]


def _check(joint: UrdfJoint) -> None:
    if joint.fault is not None:
        raise ValueError(joint.fault)
    if joint.mimics is not None:
        raise ValueError(
            f"joint {joint.name!r} mimics {joint.mimics!r}; joints must be independent"
        )
    if joint.kind in (Kind.FLOATING, Kind.PLANAR, Kind.BALL):
        allowed = "revolute, continuous, prismatic, fixed"
        kind = joint.kind.value
        raise ValueError(f"joint {joint.name!r} is {kind}; a chain may have joints: {allowed}")


def _listed(names) -> str:
    names = list(names)
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(names[:_MOST_NAMES]) + more


def summed(parts: list[tuple[Array, Inertial]], frame: Array) -> Body:
    """One body in a frame (4, 4) from parts, each with its link's transform (4, 4)."""
    mass, moment, tensor = 0.0, np.zeros(3), np.zeros((3, 3))
    for T, inertial in parts:
        G = rigid.inverse(frame) @ T @ inertial.origin
        R, com, m = G[:3, :3], G[:3, 3], float(inertial.body.mass)
        mass, moment = mass + m, moment + m * com
        tensor += R @ tensor_of(inertial.body.inertia) @ R.T + m * _offset(com)
    if not parts:
        return Body(mass=0)
    com = moment / mass
    tensor -= mass * _offset(com)
    i = [float(tensor[place]) for place in PLACES]
    return Body(mass=mass, com=(*map(float, com),), inertia=(*i,))  # pyright: ignore


def _offset(r: Array) -> Array:
    """Inertia of a unit mass at r (3,) about the origin."""
    return (r @ r) * np.eye(3) - np.outer(r, r)
