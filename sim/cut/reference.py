"""From a tool motion to what the motors are asked for: inverse kinematics under joint limits."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.kinematics import Limits, Robot, inverse_path
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion

from .path import CuttingPath
from .timing import PathLimits
from .tool_motion import LimitHit, ToolMotion, cut


def joint_reference(
    motion: ToolMotion,
    robot: Robot,
    limits: Limits,
    *,
    start: ArrayLike | None = None,
    shift: Array | None = None,
) -> Array:
    """Motor angles (N, 6) [rad], arm side, that put the tool on the motion: one branch throughout.

    Args:
        robot: its D-H description.
        limits: joint ranges; leaving them is an error.
        start: (6,) [rad], the solution nearest to it is taken; zero pose by default.
        shift: (N, 3) [m], subtracted from the programmed positions, such as an anticipated
            deflection.

    Raises:
        UnreachableError: a position is out of reach; says by how much.
        ValueError: the joint limits forbid the pose or are left on the way.
    """
    position = motion.position if shift is None else motion.position - shift
    T_base_tool = transform(from_quaternion(motion.quaternion), position)
    return inverse_path(robot, T_base_tool, start, limits)


def joint_speed(phi: Array, step: float) -> Array:
    """(N, 6) [rad/s], central differences."""
    return np.gradient(phi, step, axis=0)


def plan_cut(
    path: CuttingPath,
    tool_quaternion: ArrayLike,
    speed: float,
    robot: Robot,
    joint_limits: Limits,
    *,
    start: ArrayLike | None = None,
    path_limits: PathLimits | None = None,
    rest_before: float = 0.28,
    rest_after: float = 0.35,
    step: float = 0.004,
) -> tuple[ToolMotion, Array]:
    """A cut and its joint reference, at the highest speed that path and joint limits allow.

    Where a joint would be too fast, the whole cut is slowed down and `limits_hit` names the joint.

    Returns:
        The motion, and motor angles (N, 6) [rad].
    """
    reached, slowed = speed, ()
    while True:
        motion = cut(
            path,
            tool_quaternion,
            reached,
            limits=path_limits,
            rest_before=rest_before,
            rest_after=rest_after,
            step=step,
        )
        phi = joint_reference(motion, robot, joint_limits, start=start)
        use = np.abs(joint_speed(phi, step)) / np.array(joint_limits.speed)
        if use.max() <= 1.0:
            break
        slowed = _first_hit(use, motion.time)
        reached = motion.reached_speed / use.max() * (1.0 - 1e-6)
    hits = motion.limits_hit + slowed
    return replace(motion, programmed_speed=float(speed), limits_hit=hits), phi


def _first_hit(use: Array, time: Array) -> tuple[LimitHit, ...]:
    """The joint that asks for most of its speed limit, and when it first passes it."""
    axis = int(np.argmax(use.max(axis=0)))
    return (("joint_speed", axis + 1, float(time[np.argmax(use[:, axis] > 1.0)])),)
