"""Bodies, joints and sites of a compiled MJCF as the links and joints of a document.

A body is a link, and so is a named site, which is fixed to its body. A body with several joints, or
with a joint beside its origin, has links between them that weigh nothing. Joint variables are those
of the file (qpos).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, pi

import mujoco
import numpy as np

from armside.arrays import Array
from armside.kinematics import Body, rotation
from armside.kinematics.rigid import transform
from armside.kinematics.urdf.elements import (
    WHOLE_TURN,
    Document,
    Fault,
    Inertial,
    Kind,
    UrdfJoint,
)

HELD = ("flex_", "struct_")
"""Beginnings of the names of springs, which are held at rest."""
_KINDS = {
    mujoco.mjtJoint.mjJNT_FREE: Kind.FLOATING,
    mujoco.mjtJoint.mjJNT_BALL: Kind.BALL,
    mujoco.mjtJoint.mjJNT_SLIDE: Kind.PRISMATIC,
    mujoco.mjtJoint.mjJNT_HINGE: Kind.REVOLUTE,
}


@dataclass(frozen=True)
class _Mount:
    """Link that the next joint is mounted on, and the place (4, 4) of its frame there."""

    link: str
    place: Array


def mjcf_document(mj: mujoco.MjModel, name: str) -> Document:
    """Document of a model, whose root link is `world`.

    Raises:
        ValueError: a slide has no range; names the joint.
    """
    links: dict[str, Inertial | Fault | None] = {"world": None}
    joints: list[UrdfJoint] = []
    for body in range(1, mj.nbody):
        for joint in _body_joints(mj, body):
            links[joint.child] = None
            joints.append(joint)
        links[body_name(mj, body)] = _inertial(mj, body)
    for joint in _sites(mj):
        links[joint.child] = None
        joints.append(joint)
    return Document(name, links, tuple(joints))


def body_name(mj: mujoco.MjModel, body: int) -> str:
    """Name of a body; `body_N` where the file has none."""
    return mj.body(body).name or f"body_{body}"


def joint_name(mj: mujoco.MjModel, joint: int) -> str:
    """Name of a joint; `joint_N` where the file has none."""
    return mj.joint(joint).name or f"joint_{joint}"


def _body_joints(mj: mujoco.MjModel, body: int) -> Iterator[UrdfJoint]:
    """Joints from the parent of a body to the body itself."""
    own, first = body_name(mj, body), int(mj.body_jntadr[body])
    place = _placed(mj.body_pos[body], mj.body_quat[body])
    mount = _Mount(body_name(mj, int(mj.body_parentid[body])), place)
    for joint in range(first, first + int(mj.body_jntnum[body])):
        if not joint_name(mj, joint).startswith(HELD):
            yield _joint(mj, joint, mount, f"{own}/{joint_name(mj, joint)}")
            back = transform(np.eye(3), -mj.jnt_pos[joint])
            mount = _Mount(f"{own}/{joint_name(mj, joint)}", back)
    yield _fixed(f"{own}/body", mount, own)


def _joint(mj: mujoco.MjModel, joint: int, mount: _Mount, child: str) -> UrdfJoint:
    kind, axis = _KINDS[mujoco.mjtJoint(int(mj.jnt_type[joint]))], np.array(mj.jnt_axis[joint])
    origin = mount.place @ transform(np.eye(3), mj.jnt_pos[joint])
    reference = float(mj.qpos0[mj.jnt_qposadr[joint]])
    if kind is Kind.REVOLUTE:
        origin = origin @ transform(rotation.from_axis_angle(axis, -reference), np.zeros(3))
    elif kind is Kind.PRISMATIC:
        origin = origin @ transform(np.eye(3), -reference * axis)
    return UrdfJoint(
        name=joint_name(mj, joint),
        kind=kind,
        parent=mount.link,
        child=child,
        origin=origin,
        axis=axis,
        range=_range(mj, joint, kind),
        speed=pi,
        mimics=_leader(mj, joint),
    )


def _range(mj: mujoco.MjModel, joint: int, kind: Kind) -> tuple[float, float]:
    if kind not in (Kind.REVOLUTE, Kind.PRISMATIC):
        return -inf, inf
    if mj.jnt_limited[joint]:
        lower, upper = map(float, mj.jnt_range[joint])
        return lower, upper
    if kind is Kind.PRISMATIC:
        raise ValueError(f"joint {joint_name(mj, joint)!r}: a slide needs a range")
    return -WHOLE_TURN, WHOLE_TURN


def _leader(mj: mujoco.MjModel, joint: int) -> str | None:
    """Joint that an equality makes this one follow."""
    for i in range(mj.neq):
        follows = mj.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT and mj.eq_active0[i]
        if follows and mj.eq_obj1id[i] == joint:
            leader = int(mj.eq_obj2id[i])
            return joint_name(mj, leader) if leader >= 0 else "a constant"
    return None


def _sites(mj: mujoco.MjModel) -> Iterator[UrdfJoint]:
    taken = {body_name(mj, body) for body in range(mj.nbody)}
    for site in range(mj.nsite):
        if name := mj.site(site).name:
            place = _placed(mj.site_pos[site], mj.site_quat[site])
            mount = _Mount(body_name(mj, int(mj.site_bodyid[site])), place)
            child = f"site/{name}" if name in taken else name
            yield _fixed(f"site/{name}", mount, child)


def _fixed(name: str, mount: _Mount, child: str) -> UrdfJoint:
    axis = np.array([0.0, 0.0, 1.0])
    fixed, limits = Kind.FIXED, (-inf, inf)
    return UrdfJoint(name, fixed, mount.link, child, mount.place, axis, limits, pi, None)


def _inertial(mj: mujoco.MjModel, body: int) -> Inertial | Fault | None:
    mass = float(mj.body_mass[body])
    if not mass > 0:
        return None
    x, y, z = map(float, mj.body_inertia[body])
    try:
        own = Body(mass=mass, inertia=(x, y, z, 0, 0, 0))
    except ValueError as error:
        return Fault(f"body {body_name(mj, body)!r}: {error}")
    return Inertial(_placed(mj.body_ipos[body], mj.body_iquat[body]), own)


def _placed(position: Array, quaternion: Array) -> Array:
    return transform(rotation.from_quaternion(quaternion), position)
