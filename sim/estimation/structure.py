"""Springs across the axes of an arm: bearings and links in series with the gears.

The extended flexible joint model: each joint that carries the structure gives way about its own
axis, which is the gear, and about the two directions across it. Moberg, Wernholt, Hanssen and
Brogardh, "Modeling and parameter estimation of robot manipulators using extended flexible joint
models" (2014). The first axis stands on its foot, where the robot is bolted down.

Where a linkage drives an axis, the springs stand behind the passive joint that follows the motor.
An arm whose axes are parallel has none: they would move its tool out of the plane in which it can
be corrected.
"""

import mujoco
import numpy as np

from armside.arrays import Array

from ..robot.individual import HiddenHinge, joints, with_hinges
from ..robot.linkage import passive_joints
from ..robot.model import RobotModel, robot_model

STRUCTURAL = 3
"""Axes with springs across them, the first ones: those behind carry little and stand far out."""
DAMPING_TIME = 2e-4
"""Damping over stiffness [s], as of welded and cast structures. ESTIMATE"""

_PARALLEL = np.cos(0.01)  # cosine of the largest angle between parallel axes


def with_structure(robot: RobotModel) -> RobotModel:
    """The robot with springs across its first axes in place of those its file knows, each as stiff
    as the gear beside: a start for an identification."""
    spec = robot.parsed()
    for name in [joint.name for joint in spec.joints if joint.name.startswith("struct_")]:
        spec.delete(spec.joint(name))
    bare = robot_model(spec)
    structural = range(0 if _is_in_a_plane(bare) else min(STRUCTURAL, bare.n_axes))
    hinges = [hinge for axis in structural for hinge in across(bare, axis)]
    return with_hinges(bare, hinges, "across") if hinges else bare


def _is_in_a_plane(robot: RobotModel) -> bool:
    """Whether all axes that turn are parallel, as those of a SCARA."""
    mj, data = robot.mj, mujoco.MjData(robot.mj)
    mujoco.mj_kinematics(mj, data)
    motors = [mj.joint(f"motor_{i + 1}") for i in range(robot.n_axes)]
    turning = [m.id for m in motors if m.type[0] == mujoco.mjtJoint.mjJNT_HINGE]
    along = data.xaxis[turning]
    return bool((np.abs(along @ along.T) > _PARALLEL).all())


def across(robot: RobotModel, axis: int) -> list[HiddenHinge]:
    """The two springs across one axis, counted from 0; none across one that slides, or within a
    linkage whose passive joints cannot follow them."""
    mj = robot.mj
    joint = mj.joint(f"motor_{axis + 1}")
    carrying = _carrying(robot, axis)
    if joint.type[0] != mujoco.mjtJoint.mjJNT_HINGE or carrying is None:
        return []
    body, along, place = carrying
    if axis == 0:
        place = _foot(mj, body, along, place)
    stiffness = float(mj.joint(f"flex_{axis + 1}").stiffness.flat[0])
    return [
        HiddenHinge(
            body=mj.body(body).name,
            axis=tuple(direction.tolist()),
            position=tuple(place.tolist()),
            stiffness=stiffness,
            damping=DAMPING_TIME * stiffness,
        )
        for direction in _perpendicular(along)
    ]


def _carrying(robot: RobotModel, axis: int) -> tuple[int, Array, Array] | None:
    """Body on the way to the tool that rests on an axis; direction and place of it there."""
    mj, chain = robot.mj, [int(robot.mj.site_bodyid[robot.mj.site("tool0").id])]
    while parent := int(mj.body_parentid[chain[-1]]):
        chain.append(parent)
    joint = int(mj.joint(f"motor_{axis + 1}").id)
    followers = (mj.dof_jntid[dof] for dof in passive_joints(mj) if robot.posture[dof, axis])
    for j in (joint, *map(int, followers)):
        body = int(mj.jnt_bodyid[j])
        if body in chain:
            break
    else:
        return None
    along, place = mj.jnt_axis[j].copy(), mj.jnt_pos[j].copy()
    pinned = {int(mj.site_bodyid[site]) for site in _pins(mj)}
    while j != joint and body in pinned and body != chain[0]:  # beyond the lever of a linkage
        following = chain[chain.index(body) - 1]
        mujoco.mju_quat2Mat(R := np.empty(9), mj.body_quat[following])
        along = R.reshape(3, 3).T @ along
        place = R.reshape(3, 3).T @ (place - mj.body_pos[following])
        body = following
    # Passive joints that are too few to follow what leaves the plane of their linkage.
    planar = len(joints(mj, "link_")) < 3 * (len(_pins(mj)) // 2)
    return None if planar and _within_loop(mj, body) else (body, along, place)


def _pins(mj: mujoco.MjModel) -> list[int]:
    """Sites at which linkages are closed."""
    closing = mj.eq_type == mujoco.mjtEq.mjEQ_CONNECT
    return [*map(int, mj.eq_obj1id[closing]), *map(int, mj.eq_obj2id[closing])]


def _within_loop(mj: mujoco.MjModel, body: int) -> bool:
    """Whether a body carries one side of a linkage and not the other."""

    def carries(site: int) -> bool:
        at = int(mj.site_bodyid[site])
        while at and at != body:
            at = int(mj.body_parentid[at])
        return at == body

    pins = _pins(mj)
    half = len(pins) // 2
    return any(carries(a) != carries(b) for a, b in zip(pins[:half], pins[half:], strict=True))


def _perpendicular(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors across an axis and each other, along the body's own axes where they can."""
    along: Array = axis / float(np.linalg.norm(axis))
    first = np.eye(3)[int(np.argmin(np.abs(along)))]
    first = first - (first @ along) * along
    first = first / np.linalg.norm(first)
    second: Array = np.cross(along, first).astype(np.float64)
    return first, second


def _foot(mj: mujoco.MjModel, body: int, axis: Array, place: Array) -> Array:
    """Point of an axis nearest to the origin of the base, in the axes of its body."""
    data = mujoco.MjData(mj)
    mujoco.mj_kinematics(mj, data)
    R = data.xmat[body].reshape(3, 3)
    origin = R.T @ -data.xpos[body]
    along = axis / np.linalg.norm(axis)
    return place + ((origin - place) @ along) * along
