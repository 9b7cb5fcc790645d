"""Springs across the axes of an arm: bearings and links in series with the gears.

The extended flexible joint model: each joint that carries the structure gives way about its own
axis, which is the gear, and about the two directions across it. Moberg, Wernholt, Hanssen and
Brogardh, "Modeling and parameter estimation of robot manipulators using extended flexible joint
models" (2014). The first axis stands on its foot, where the robot is bolted down.
"""

from typing import Any

import mujoco
import numpy as np

from armside.arrays import Array

from ...robot.flexibility import Flexibility, without
from ...robot.individual import HiddenHinge, with_hinges
from ...robot.model import RobotModel, robot_model
from ..arm_springs import arm_and_wrist

DAMPING_TIME = 2e-4
"""Damping over stiffness [s], as of welded and cast structures. ESTIMATE"""


def with_structure(robot: RobotModel) -> RobotModel:
    """The robot with springs across its first axes, in place of those its file knows.

    Each is as stiff as the gear it stands beside: a start for an identification.
    """
    spec = robot.parsed()
    without(spec, Flexibility.GEARS)
    bare = robot_model(spec)
    structural, _ = arm_and_wrist(robot.n_axes)
    hinges = [hinge for axis in range(structural) for hinge in across(bare, axis)]
    return with_hinges(bare, hinges, "across")


def across(robot: RobotModel, axis: int) -> list[HiddenHinge]:
    """The two springs across one axis, counted from 0."""
    mj = robot.mj
    joint = mj.joint(f"motor_{axis + 1}")
    body = mj.body(int(joint.bodyid[0]))
    along, place = np.array(joint.axis), np.array(joint.pos)
    if axis == 0:
        place = _foot(mj, int(body.id), along, place)
    stiffness = float(mj.joint(f"flex_{axis + 1}").stiffness.flat[0])
    rest: dict[str, Any] = {"stiffness": stiffness, "damping": DAMPING_TIME * stiffness}
    return [
        HiddenHinge(body=body.name, axis=_triple(a), position=_triple(place), **rest)
        for a in _perpendicular(along)
    ]


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


def _triple(vector: Array) -> tuple[float, float, float]:
    x, y, z = map(float, vector)
    return x, y, z
