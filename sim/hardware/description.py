"""Hardware of a robot as far as its file states it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

Values = Mapping[str, tuple[float, ...]]
"""Numbers by the key of the file: one for each axis, or as many as the key has."""
Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class LinkBody:
    """Mass of one link, base or tool; None is estimated."""

    mass: float | None = None
    """[kg]."""
    centre: Vector | None = None
    """Centre of mass [m]."""
    inertia: tuple[float, float, float, float, float, float] | None = None
    """xx, yy, zz, xy, xz, yz about the centre of mass [kg m^2]."""


@dataclass(frozen=True, kw_only=True)
class StructureHinge:
    """Elastic hinge of the structure, in the axes of the link it lies on."""

    name: str
    link: int
    """Moving link from 1, behind its gear; 0: the base, before the first motor."""
    direction: Vector
    point: Vector
    """[m]."""
    stiffness: float
    """[N m/rad]."""
    damping: float | None
    """[N m s/rad]; None: from the damping ratio."""
    damping_ratio: float


@dataclass(frozen=True, kw_only=True)
class Hardware:
    """Tables of a robot file that describe its hardware."""

    mass: float | None = None
    """Of the whole robot with its base, without the tool [kg]."""
    timestep: float = 0.0005
    """Physics step [s]."""
    base: LinkBody = LinkBody()
    bodies: tuple[LinkBody, ...] = ()
    """One for each moving link, in the axes of its D-H frame; none: all estimated."""
    tool: LinkBody = LinkBody()
    """In the axes of the tool frame."""
    drives: Values = field(default_factory=dict)
    gears: Values = field(default_factory=dict)
    rigid: bool = False
    """Gears without springs."""
    effects: Values = field(default_factory=dict)
    structure: tuple[StructureHinge, ...] = ()
