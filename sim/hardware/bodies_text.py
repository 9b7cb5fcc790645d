"""Bodies of an MJCF: the chain from base to tool with its joints, masses, shapes and sites."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armside.arrays import Array
from armside.kinematics import Joint, Limits

from .chain import Frame, points
from .description import StructureHinge
from .inertia import cylinder
from .masses import Mass, Masses
from .text import number, pose, row

_GREY, _DARK = 'material="shell"', 'material="joint"'


class Spring(NamedTuple):
    """Spring and damper of a joint."""

    stiffness: float
    damping: float


@dataclass(frozen=True, eq=False)
class Tree:
    """All that the bodies of an MJCF are written from."""

    chain: list[Frame]
    masses: Masses
    limits: Limits
    armature: Sequence[float] | Array
    """(n,) [kg m^2]."""
    gears: Sequence[Spring]
    """(n,), or none: rigid gears."""
    structure: Sequence[tuple[StructureHinge, Spring]]
    imu: Array
    """(4, 4), in the tool frame."""
    estimates: tuple[str, str] = ("", "")
    """Words of the comments at armatures and springs."""


def worldbody(tree: Tree) -> list[str]:
    """Lines of <worldbody>."""
    lines = ["  <worldbody>", '    <body name="base" childclass="robot">']
    lines += _inertial(tree.masses.base, 6) + _base_shapes(tree)
    depth = len(tree.chain)
    for i in range(depth):
        lines += _opened(tree, i)
    pad = " " * (6 + 2 * depth)
    end = tree.chain[-1].end
    lines += [
        f'{pad}<site name="tool0"{pose(end)}/>',
        f'{pad}<site name="imu"{pose(end @ tree.imu)} type="box" size="0.02 0.02 0.012"/>',
        f'{pad}<site name="tracker_target"{pose(end)}/>',
        f'{pad}<body name="tool"{pose(end)}>',
        *_inertial(tree.masses.tool, 8 + 2 * depth),
        *_tool_shapes(tree.masses.tool, pad),
        f"{pad}</body>",
    ]
    lines += [" " * (6 + 2 * i) + "</body>" for i in reversed(range(depth))]
    return [*lines, "    </body>", "  </worldbody>"]


def _opened(tree: Tree, i: int) -> list[str]:
    frame, pad = tree.chain[i], " " * (6 + 2 * i)
    inside = pad + "  "
    lines = [f'{pad}<body name="link_{i + 1}"{pose(frame.place)}>']
    lines += _inertial(tree.masses.links[i], len(inside))
    before = [one for one in tree.structure if one[0].link == 0] if i == 0 else []
    lines += [_hinge(*one, pad=inside, to_base=frame.place) for one in before]
    axis = f'axis="0 0 {number(frame.sign)}"'
    slide = ' type="slide"' if frame.joint is Joint.PRISMATIC else ""
    ends = row([tree.limits.lower[i], tree.limits.upper[i]])
    rotor = f' armature="{number(tree.armature[i])}"' if len(tree.armature) else ""
    if tree.estimates[0]:
        lines.append(f"{inside}<!-- {tree.estimates[0]} -->")
    lines.append(
        f'{inside}<joint name="motor_{i + 1}" class="motor" {axis}{slide} range="{ends}"{rotor}/>'
    )
    if len(tree.gears):
        spring = _spring(tree.gears[i])
        if tree.estimates[1]:
            lines.append(f"{inside}<!-- {tree.estimates[1]} -->")
        lines.append(f'{inside}<joint name="flex_{i + 1}" class="flex" {axis}{slide}{spring}/>')
    behind = [one for one in tree.structure if one[0].link == i + 1]
    lines += [_hinge(*one, pad=inside, link=frame.link) for one in behind]
    return lines + _shapes(frame, tree.masses.links[i], inside)


def _hinge(
    hinge: StructureHinge,
    spring: Spring,
    *,
    pad: str,
    link: Array | None = None,
    to_base: Array | None = None,
) -> str:
    """A hinge in axes of a D-H frame, or of the base in front of the first motor."""
    T = np.linalg.inv(to_base) if to_base is not None else np.eye(4) if link is None else link
    axis, at = T[:3, :3] @ np.array(hinge.direction), T[:3, :3] @ np.array(hinge.point) + T[:3, 3]
    place = f'axis="{row(axis)}" pos="{row(at)}"'
    return f'{pad}<joint name="struct_{hinge.name}" class="struct" {place}{_spring(spring)}/>'


def _spring(spring: Spring) -> str:
    return f' stiffness="{number(spring.stiffness)}" damping="{number(spring.damping)}"'


def _inertial(mass: Mass, indent: int) -> list[str]:
    pad, numbers = " " * indent, f'pos="{row(mass.centre)}" mass="{number(mass.mass)}"'
    return [
        f"{pad}<!-- {mass.source} -->",
        f'{pad}<inertial {numbers} fullinertia="{row(mass.inertia)}"/>',
    ]


def _base_shapes(tree: Tree) -> list[str]:
    """A column from the floor to the first joint."""
    first = points(tree.chain)[0]
    _, radius = cylinder(tree.masses.base.mass, first)
    top = max(float(first[2]), 0.02)
    wide = min(radius, 0.2 * tree.masses.length + 0.02)
    shape = f'type="cylinder" size="{wide:.4g} {top / 2:.4g}" pos="{row([first[0], first[1]])}'
    return [f'      <geom {shape} {top / 2:.4g}" {_DARK}/>']


def _shapes(frame: Frame, mass: Mass, pad: str) -> list[str]:
    """A drum about the joint and a capsule to the next."""
    _, radius = cylinder(mass.mass, frame.along)
    radius = min(radius, 0.12)
    drum = f'type="cylinder" size="{1.15 * radius:.4g} {1.2 * radius:.4g}"'
    lines = [f"{pad}<geom {drum} {_DARK}/>"]
    if np.linalg.norm(frame.along) > radius:
        fromto = f'fromto="0 0 0 {row(np.round(frame.along, 6))}"'
        lines.append(f'{pad}<geom type="capsule" size="{0.8 * radius:.4g}" {fromto} {_GREY}/>')
    return lines


def _tool_shapes(mass: Mass, pad: str) -> list[str]:
    length = max(2.0 * float(np.linalg.norm(mass.centre)), 0.02)
    _, radius = cylinder(mass.mass, np.array([0.0, 0.0, length]))
    size = f'size="{min(radius, 0.1):.4g}"'
    shape = f'type="cylinder" {size} fromto="0 0 0 {row(np.round(2.0 * mass.centre, 6))}"'
    if np.linalg.norm(mass.centre) < 1e-3:
        shape = f'type="sphere" {size}'
    return [f'{pad}  <geom {shape} material="tool"/>']
