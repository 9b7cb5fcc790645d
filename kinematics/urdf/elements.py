"""Links and joints of a file of an arm, whatever its format: what a chain is made of."""

from dataclasses import dataclass
from enum import Enum
from math import pi

from armside.arrays import Array

from ..equations.inertial_model import Body

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
    speed: float
    """[rad/s or m/s]; pi where the file has none, as in a robot file."""
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
