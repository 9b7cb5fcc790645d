"""Denavit-Hartenberg table of a chain of axes that stand anywhere in space.

A link leads from one axis to the next along their common normal. The first goes from the z-axis of
the base to axis 1 and the last two from axis n to the tip, so that base and tip frames are kept.
Where two axes are nearly parallel their normal is far away: one constant link more goes by way
of an axis at right angles. Standard convention, thesis (3.27).
"""

from dataclasses import dataclass, replace
from math import atan2

import numpy as np

from armside.arrays import Array

from .. import rigid
from ..dh import Joint, Link
from ..links import link_transform

_PARALLEL = 1e-12  # sine between axes that counts as zero
_NEARLY = 1e-3  # sine below which the common normal may be a thousand arm lengths away


@dataclass(frozen=True)
class Axis:
    """Axis of a joint at zero in base axes: joint type, a point (3,) and a unit vector (3,)."""

    joint: Joint
    point: Array
    direction: Array


def table(axes: list[Axis], tip: Array) -> tuple[tuple[Link, ...], list[Array]]:
    """Links of a chain with T_base_tip (4, 4) at zero, and the frames of its moving links."""
    kinds = [Joint.FIXED, *(axis.joint for axis in axes)]
    following = [*axes, Axis(Joint.FIXED, tip[:3, 3], tip[:3, 2])]
    F, links, frames = np.eye(4), [], []
    for kind, axis in zip(kinds, following, strict=True):
        here = [_towards(F, axis, kind)]
        F = F @ link_transform(here[0])
        if kind is not Joint.FIXED:
            frames.append(F)
        if _sine(F, axis) > _PARALLEL:  # an axis at right angles stands between them
            here.append(_normal(F, axis, Joint.FIXED))
            F = F @ link_transform(here[-1])
        links += [link for link in here if link != Link(joint=Joint.FIXED)]
    rest = rigid.inverse(F) @ tip
    theta, d, last = atan2(rest[1, 0], rest[0, 0]), rest[2, 3], links[-1]
    if last.moves and float(last.a) == float(last.alpha) == 0:  # the tip's z-axis is axis n
        links[-1] = replace(last, theta=float(last.theta) + theta, d=float(last.d) + d)
        frames[-1] = tip
    else:
        links.append(Link(theta=theta, d=d, joint=Joint.FIXED))
    return tuple(links), frames


def _sine(F: Array, axis: Axis) -> float:
    return float(np.linalg.norm(np.cross(F[:3, 2], axis.direction)))


def _towards(F: Array, axis: Axis, kind: Joint) -> Link:
    """The link to an axis, or to a line at right angles on the way if it is nearly parallel."""
    if _PARALLEL < _sine(F, axis) < _NEARLY:
        foot = axis.point - F[:3, 2] * (F[:3, 2] @ (axis.point - F[:3, 3]))
        return _normal(F, Axis(kind, foot, F[:3, 0]), kind)
    return _normal(F, axis, kind)


def _normal(F: Array, axis: Axis, kind: Joint) -> Link:
    """The link from the z-axis of F (4, 4) to an axis along their common normal."""
    R = F[:3, :3]
    u, p = R.T @ axis.direction, R.T @ (axis.point - F[:3, 3])
    sine = float(np.hypot(u[0], u[1]))
    if sine > _PARALLEL:
        x = np.array([-u[1], u[0]]) / sine  # z cross u
        a = float(x @ p[:2])
        along = (p[0] * u[0] + p[1] * u[1]) / sine**2  # of the point, beyond the normal's foot
        return Link(atan2(x[1], x[0]), p[2] - along * u[2], a, atan2(sine, u[2]), kind)
    a = float(np.hypot(p[0], p[1]))
    theta, a = (atan2(p[1], p[0]), a) if a > _PARALLEL else (0.0, 0.0)
    return Link(theta, 0.0, a, 0.0 if u[2] > 0 else np.pi, kind)
