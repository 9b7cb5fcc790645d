"""Masses, centres and inertias of links, base and tool: those of the file, the others estimated.

Without masses the whole robot has `hardware.PER_CUBE` times its stretched length cubed, its base a
fifth, and each link a part in proportion to the length of the arm from its joint on. A centre of
mass lies midway to the next joint; an inertia is that of a uniform cylinder on that line.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics.equations.inertial_model import Body
from armside.kinematics.urdf import UrdfArm

from .body_frames import Frame, points
from .hardware import BASE, LEAST, PER_CUBE, TOOL, Hardware, LinkBody, Report

DENSITY = 2000.0
"""[kg/m^3] of a link: castings of aluminium with motors, gears and cavities. ESTIMATE."""
SMALLEST = 1e-9
"""[kg m^2], a principal moment below which a body counts as a point."""
Six = tuple[float, float, float, float, float, float]


def matrix(six: Six) -> Array:
    """Inertia tensor (3, 3)."""
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def six_of(tensor: Array) -> Six:
    """xx, yy, zz, xy, xz, yz of a tensor (3, 3)."""
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return tuple(float(tensor[i]) for i in places)  # pyright: ignore[reportReturnType]


def rotated(six: Six, R: Array) -> Six:
    """The inertia in other axes: R (3, 3) from its own to those."""
    return six_of(R @ matrix(six) @ R.T)


def cylinder(mass: float, along: Array) -> tuple[float, float]:
    """Length and radius [m] of a uniform cylinder of that mass [kg] along a vector (3,) [m].

    One as short as wide where the vector is shorter than the cube of that volume.
    """
    volume = mass / DENSITY
    length = max(float(np.linalg.norm(along)), volume ** (1.0 / 3.0))
    return length, float(np.sqrt(volume / (np.pi * length)))


def of_cylinder(mass: float, along: Array) -> Six:
    """Inertia of that cylinder about its middle, in the axes of the vector."""
    length, radius = cylinder(mass, along)
    about, across = mass * radius**2 / 2.0, mass * (3.0 * radius**2 + length**2) / 12.0
    size = float(np.linalg.norm(along))
    u = along / size if size > 1e-9 else np.array([0.0, 0.0, 1.0])
    return six_of(across * np.eye(3) + (about - across) * np.outer(u, u))


_IDENTITY = np.eye(4)
_CYLINDER = f"ESTIMATE: uniform cylinder of {DENSITY:g} kg/m^3 to the next joint"


@dataclass(frozen=True)
class Mass:
    """A complete rigid body in the axes of its MJCF body."""

    mass: float
    centre: Array
    """(3,) [m]."""
    inertia: Six
    """About the centre [kg m^2]."""
    source: str
    """For the comment in the MJCF."""


@dataclass(frozen=True)
class Masses:
    """Bodies of a robot."""

    base: Mass
    links: tuple[Mass, ...]
    tool: Mass
    length: float
    """Stretched length of the arm [m]."""


def masses(given: Hardware, chain: list[Frame], report: Report) -> Masses:
    """Bodies of a robot, completed. Estimates are noted in `report`."""
    # Stretched length of the arm from each joint on; of a first that turns, across its axis.
    along = np.array([frame.along for frame in chain])
    along[0, 2] = 0.0
    lengths = np.cumsum(np.linalg.norm(along, axis=1)[::-1])[::-1]
    bodies = given.bodies or (LinkBody(),) * len(chain)
    of_links, of_base = _shares(given, bodies, lengths, report)
    rule, rows = "ESTIMATE: midway, joint axes", zip(bodies, of_links, chain, strict=True)
    links = tuple(
        _mass(f"body {i}", body, mass, frame.along, rule, report, frame.link)
        for i, (body, mass, frame) in enumerate(rows, 1)
    )
    column = np.array([0.0, 0.0, points(chain)[1 if len(chain) > 1 else 0][2]])
    base = _mass("base", given.base, of_base, column, "", report)
    if (of_tool := given.tool.mass) is None:
        rule, whole = f"ESTIMATE: {100 * TOOL:g} % of the robot", of_base + float(of_links.sum())
        of_tool = float(report.take("tool: mass", [TOOL * whole], rule)[0])
    along = np.array([0.0, 0.0, (of_tool / DENSITY) ** (1.0 / 3.0)])
    rule = "ESTIMATE: a block on the flange"
    tool = _mass("tool", given.tool, of_tool, along, rule, report)
    return Masses(base, links, tool, float(lengths[0]))


def _shares(
    given: Hardware, bodies: tuple[LinkBody, ...], lengths: Array, report: Report
) -> tuple[Array, float]:
    known = np.array([np.nan if body.mass is None else body.mass for body in bodies])
    weight = np.maximum(lengths, LEAST * lengths[0]) + 1e-9
    missing, total, base = np.isnan(known), given.mass, given.base.mass
    if total is None and missing.all():
        length = float(lengths[0])
        rule = f"ESTIMATE: {PER_CUBE:g} kg/m^3 times the stretched length {length:.3g} m cubed"
        total = float(report.take("hardware: mass", [PER_CUBE * max(length, 0.1) ** 3], rule)[0])
    least = float(known[~missing].sum()) + (base or 0.0)
    if total is not None and not missing.any() and total < least * (1.0 - 1e-9):
        raise ValueError(_TOO_LIGHT.format(total, least))
    if missing.any():
        stated = float(known[~missing].sum())
        if total is None:
            per_weight = stated / float(weight[~missing].sum())
        else:
            moving = (1.0 - BASE) * total if base is None else total - base
            if (left := moving - stated) <= 0.0:
                raise ValueError(_TOO_LIGHT.format(total, total - left))
            per_weight = left / float(weight[missing].sum())
        rule = "ESTIMATE: in proportion to the length of the arm from the joint on"
        known[missing] = report.take("body: mass", per_weight * weight[missing], rule)
    if base is None:
        left = BASE / (1.0 - BASE) * known.sum() if total is None else total - known.sum()
        left = max(left, 0.01 * known.sum())
        rule = "ESTIMATE: a fifth of the robot" if total is None else "the rest of hardware: mass"
        base = float(report.take("base: mass", [left], rule)[0])
    return known, base


_TOO_LIGHT = "hardware: mass must exceed that of base and links, got {:g} kg and {:g} kg"


def _mass(
    name: str,
    body: LinkBody,
    mass: float,
    along: Array,
    rule: str,
    report: Report,
    frame: Array = _IDENTITY,
) -> Mass:
    """A body on a line, at whose middle its centre is taken. frame: (4, 4), of what is given."""
    R, parts = frame[:3, :3], ("mass", "centre", "inertia")
    estimated = [part for part in parts if getattr(body, part) is None]
    if body.centre is not None:
        centre = frame[:3, 3] + R @ np.array(body.centre)
    else:
        centre = report.take(f"{name}: centre", along / 2.0, rule) if rule else along / 2.0
    if body.inertia is not None:
        inertia = rotated(body.inertia, R)
    else:
        taken = report.take(f"{name}: inertia", of_cylinder(mass, along), _CYLINDER).tolist()
        inertia = tuple(taken)
    source = f"ESTIMATE: {', '.join(estimated)}" if estimated else "of the robot file"
    return Mass(mass, centre, inertia, source)  # pyright: ignore[reportArgumentType] - six of them


def bodies_of(arm: UrdfArm) -> tuple[LinkBody, ...]:
    """Bodies of the moving links, in the axes of their D-H frames; none where it has no masses."""
    if arm.bodies is None:
        return ()
    moving = [b for b, link in zip(arm.bodies, arm.robot.links, strict=True) if link.moves]
    return tuple(link_body(body) for body in moving)


def link_body(body: Body) -> LinkBody:
    """A body, or one to be estimated where it has no mass; so is the inertia of a point."""
    if not float(body.mass) > 0.0:
        return LinkBody()
    x, y, z = map(float, body.com)
    xx, yy, zz, xy, xz, yz = map(float, body.inertia)
    inertia = xx, yy, zz, xy, xz, yz
    point = np.linalg.eigvalsh(matrix(inertia))[0] < SMALLEST
    return LinkBody(mass=float(body.mass), centre=(x, y, z), inertia=None if point else inertia)
