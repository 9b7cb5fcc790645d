"""MJCF of any arm as a Denavit-Hartenberg robot, and its masses on the links of one.

A body is a link, and so is a named site, which is fixed to its body. A body with several joints, or
with a joint beside its origin, has links between them that weigh nothing. Joint variables are those
of the file (qpos).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path

import mujoco
import numpy as np

from armside.arrays import Array
from armside.kinematics import Body, Robot, rotation
from armside.kinematics.rigid import link_frames, transform
from armside.kinematics.urdf import UrdfArm
from armside.kinematics.urdf.links_and_joints import (
    TOOL,
    WHOLE_TURN,
    Document,
    Fault,
    Inertial,
    Kind,
    UrdfJoint,
    chain,
    children,
    summed,
)
from armside.kinematics.urdf.reader import arm_of

from ..robot.mjcf import model_name
from ..robot.model import RobotModel

_ENDS = int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)
"""Equalities that join two bodies."""
HELD = ("flex_", "struct_")
"""Beginnings of the names of springs, which are held at rest."""
_KINDS = {
    mujoco.mjtJoint.mjJNT_FREE: Kind.FLOATING,
    mujoco.mjtJoint.mjJNT_BALL: Kind.BALL,
    mujoco.mjtJoint.mjJNT_SLIDE: Kind.PRISMATIC,
    mujoco.mjtJoint.mjJNT_HINGE: Kind.REVOLUTE,
}


Mount = tuple[str, Array]
"""Link that the next joint is mounted on, and the place (4, 4) of its frame there."""


def mjcf_document(mj: mujoco.MjModel, name: str) -> Document:
    """Document of a model, its root link `world`. Raises ValueError for a slide without range."""
    links: dict[str, Inertial | Fault | None] = {"world": None}
    joints: list[UrdfJoint] = []
    for body in range(1, mj.nbody):
        for joint in _body_joints(mj, body):
            links[joint.child] = None
            joints.append(joint)
        links[body_name(mj, body)] = _inertial(mj, body)
    taken = {body_name(mj, body) for body in range(mj.nbody)}
    for site in range(mj.nsite):
        if name_of := mj.site(site).name:
            place = _placed(mj.site_pos[site], mj.site_quat[site])
            mount = body_name(mj, int(mj.site_bodyid[site])), place
            child = f"site/{name_of}" if name_of in taken else name_of
            links[child] = None
            joints.append(_fixed(f"site/{name_of}", mount, child))
    return Document(name, links, tuple(joints))


def body_name(mj: mujoco.MjModel, body: int) -> str:
    """Name of a body; `body_N` where the file has none."""
    return mj.body(body).name or f"body_{body}"


def joint_name(mj: mujoco.MjModel, joint: int) -> str:
    """Name of a joint; `joint_N` where the file has none."""
    return mj.joint(joint).name or f"joint_{joint}"


def _body_joints(mj: mujoco.MjModel, body: int) -> Iterator[UrdfJoint]:
    own, first = body_name(mj, body), int(mj.body_jntadr[body])
    place = _placed(mj.body_pos[body], mj.body_quat[body])
    mount = body_name(mj, int(mj.body_parentid[body])), place
    for joint in range(first, first + int(mj.body_jntnum[body])):
        if not joint_name(mj, joint).startswith(HELD):
            yield _joint(mj, joint, mount, f"{own}/{joint_name(mj, joint)}")
            back = transform(np.eye(3), -mj.jnt_pos[joint])
            mount = f"{own}/{joint_name(mj, joint)}", back
    yield _fixed(f"{own}/body", mount, own)


def _joint(mj: mujoco.MjModel, joint: int, mount: Mount, child: str) -> UrdfJoint:
    kind, axis = _KINDS[mujoco.mjtJoint(int(mj.jnt_type[joint]))], np.array(mj.jnt_axis[joint])
    parent, place = mount
    origin = place @ transform(np.eye(3), mj.jnt_pos[joint])
    reference = float(mj.qpos0[mj.jnt_qposadr[joint]])
    if kind is Kind.REVOLUTE:
        origin = origin @ transform(rotation.from_axis_angle(axis, -reference), np.zeros(3))
    elif kind is Kind.PRISMATIC:
        origin = origin @ transform(np.eye(3), -reference * axis)
    return UrdfJoint(
        name=joint_name(mj, joint),
        kind=kind,
        parent=parent,
        child=child,
        origin=origin,
        axis=axis,
        range=_range(mj, joint, kind),
        speed=None,
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
    for i in range(mj.neq):
        follows = mj.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT and mj.eq_active0[i]
        if follows and mj.eq_obj1id[i] == joint:
            leader = int(mj.eq_obj2id[i])
            return joint_name(mj, leader) if leader >= 0 else "a constant"
    return None


def _fixed(name: str, mount: Mount, child: str) -> UrdfJoint:
    axis, limits = np.array([0.0, 0.0, 1.0]), (-inf, inf)
    return UrdfJoint(name, Kind.FIXED, mount[0], child, mount[1], axis, limits, None, None)


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


def read_mjcf(file: Path, base: str | None = None, tip: str | None = None) -> UrdfArm:
    """The chain from a base body to a tip, a body or a site, as a robot of the base's axes.

    base: the world by default. tip: the site `tool0` where there is one, else the only end.
    Springs (flex_*, struct_*) are held at rest. A file has no greatest speeds: they are pi rad/s.
    Raises ValueError, with file and element, where it is no serial arm, or OSError.
    """
    if not file.is_file():
        raise ValueError(f"there is no file {file}")
    try:
        mj = mujoco.MjSpec.from_file(str(file)).compile()
        name = model_name(mj)
        document = mjcf_document(mj, name[:80] if name and name.isprintable() else "robot")
        if tip is None and TOOL in document.links:
            tip = TOOL
        arm = arm_of(document, base, tip)
        _refuse_loops(mj, arm)
    except (ValueError, TypeError, RecursionError) as error:
        first_line = str(error).strip().splitlines()[0]
        raise ValueError(f"{file.name}: {first_line}") from error
    return arm


def _refuse_loops(mj: mujoco.MjModel, arm: UrdfArm) -> None:
    """Raise ValueError for a joint of the chain that an equality takes part in closing."""
    for i in range(mj.neq):
        if not mj.eq_active0[i]:
            continue
        ends = int(mj.eq_obj1id[i]), int(mj.eq_obj2id[i])
        if int(mj.eq_type[i]) not in _ENDS:
            continue
        if mj.eq_objtype[i] == mujoco.mjtObj.mjOBJ_SITE:
            ends = int(mj.site_bodyid[ends[0]]), int(mj.site_bodyid[ends[1]])
        one, other = (_moving(mj, body) for body in ends)
        for joint in np.flatnonzero(one ^ other):
            name = joint_name(mj, int(joint))
            if name in arm.joints:
                equality = mj.equality(i).name or f"equality {i}"
                raise ValueError(
                    f"joint {name!r} is part of a closed chain ({equality}); "
                    "joints must be independent"
                )


def _moving(mj: mujoco.MjModel, body: int) -> np.ndarray:
    """(njnt,) bool: joints that move a body."""
    found = np.zeros(mj.njnt, dtype=bool)
    while body > 0:
        first = int(mj.body_jntadr[body])
        found[first : first + int(mj.body_jntnum[body])] = True
        body = int(mj.body_parentid[body])
    return found


Part = tuple[Array, Inertial]
"""Transform (4, 4) of a link in base axes with every joint at zero, and what it weighs."""


@dataclass(frozen=True)
class SerialBodies:
    """Bodies for the links of a robot, and the names of those that no serial arm has."""

    bodies: tuple[Body, ...]
    """One for each link, as in an `InertialModel`; rotors are not among them."""
    left_out: tuple[str, ...]
    """Bodies with mass that a joint beside the chain to the tool moves, as of a linkage."""


def serial_bodies(model: RobotModel, robot: Robot) -> SerialBodies:
    """Bodies on the D-H links of the robot that the model is the hardware of, springs at rest.

    Raises ValueError where the chain of the model to its tool has another number of joints.
    """
    document = mjcf_document(model.mj, model_name(model.mj))
    groups, left_out = _groups(document, chain(document, None, "tool0"))
    if len(groups) != robot.n_joints:
        raise ValueError(f"{robot.name} has {robot.n_joints} joints, its model {len(groups)}")
    frames, parts = link_frames(robot, np.zeros(robot.n_joints)), iter(groups)
    pairs = zip(robot.links, frames, strict=True)
    bodies = (summed(next(parts), F) if link.moves else Body(mass=0) for link, F in pairs)
    return SerialBodies(tuple(bodies), tuple(left_out))


def _groups(
    document: Document, joints: tuple[UrdfJoint, ...]
) -> tuple[list[list[Part]], list[str]]:
    """Parts that move with each joint of the chain, and links that move beside it."""
    on_chain, below = {joint.name for joint in joints}, children(document)
    groups, left_out, T = list[list[Part]](), list[str](), np.eye(4)
    for joint in joints:
        T = T @ joint.origin
        if joint.kind is not Kind.FIXED:
            groups.append([])
        open_ends = [(joint.child, T, False)]
        while open_ends:
            link, place, beside = open_ends.pop()
            if isinstance(inertial := document.links[link], Inertial):
                if beside:
                    left_out.append(link)
                elif groups:
                    groups[-1].append((place, inertial))
            for other in below[link]:
                if other.name not in on_chain:
                    moves = beside or other.kind is not Kind.FIXED
                    open_ends.append((other.child, place @ other.origin, moves))
    return groups, left_out
