"""Refusal of a robot model whose geometry is not that of its Denavit-Hartenberg table.

The controller plans with the D-H table. A model of another geometry runs all the same, and cuts
beside the place.
"""

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import Limits, Robot

from .forward_kinematics import between, configurations, site_poses
from .linkage import LARGEST_GAP
from .mjcf import ModelError
from .model import RobotModel

POSITION = 1e-6
"""Largest difference of a site's position [m]. Learning leaves 10 um of error at the tool, which a
tenth of it must not change; both sides compute alike to 1e-14 m."""
ROTATION = 1e-6
"""Largest difference of its orientation [rad]: as much at 1 m. A right angle that is written as
1.5708 is refused."""
STEP = 0.5
"""Angle by which each axis moves to find those that differ [rad]."""


def check_kinematics(
    model: RobotModel, robot: Robot, limits: Limits, with_imu: Robot | None = None
) -> None:
    """Raise ModelError unless the tool of the MJCF is where the D-H model has it.

    Compared in the zero pose and at random motor angles within their ranges, with every spring at
    zero; closed chains must be closed there. The message has the largest difference, its place, and
    the first axis that moves the tool differently.

    with_imu: D-H model whose last frame is the IMU, compared with the site of that name.
    """
    _same_axes(model, robot, limits)
    phi = configurations(limits)
    T, opening = site_poses(model, phi)
    worst = int(np.argmax(opening))
    if opening[worst] > LARGEST_GAP:
        raise ModelError(
            f"the closed chain of the model is open by {_shown(1e3 * opening[worst])} mm at "
            f"motor angles {_degrees(phi[worst])}: its passive joints do not close it"
        )
    _compare(f"the model is no {robot.name}: its tool", T, model, robot, phi)
    if with_imu is not None:
        T, _ = site_poses(model, phi, "imu")
        _compare("the tool agrees, but the site imu", T, model, with_imu, phi)


def first_axis(model: RobotModel, robot: Robot) -> int | None:
    """Axis, counted from 1, that moves the tool by another motion; None where all axes agree.

    Each axis moves alone out of the zero pose. Its motion in base axes, T T_0^-1, does not depend
    on the tool: a tool mounted elsewhere makes no axis differ.
    """
    alone = np.vstack((np.zeros(robot.n_joints), STEP * np.eye(robot.n_joints)))
    ours, theirs = site_poses(model, alone)[0], kinematics.compile(robot).pose(alone)
    motion, expected = ours[1:] @ np.linalg.inv(ours[0]), theirs[1:] @ np.linalg.inv(theirs[0])
    differ = np.flatnonzero(_off(*between(motion, expected)))
    return int(differ[0]) + 1 if len(differ) else None


def _same_axes(model: RobotModel, robot: Robot, limits: Limits) -> None:
    n = model.posture.shape[1]
    if not n == robot.n_joints == len(limits.lower):
        raise ModelError(
            f"the model has {n} axes, the D-H model {robot.name} {robot.n_joints} and its limits "
            f"{len(limits.lower)}: they must be as many"
        )


def _compare(what: str, T: Array, model: RobotModel, robot: Robot, phi: Array) -> None:
    """Raise ModelError unless the poses T (K, 4, 4) are those of the D-H model at phi (K, n)."""
    position, rotation = between(T, kinematics.compile(robot).pose(phi))
    off = _off(position, rotation)
    if not off.any():
        return
    worst = int(np.argmax(position / POSITION + rotation / ROTATION))
    by = f"{_shown(1e3 * position[worst])} mm and {_shown(np.rad2deg(rotation[worst]))} deg"
    at = f"at motor angles {_degrees(phi[worst])}"
    axis, where = first_axis(model, robot), ""
    if axis is not None:
        where = f"; axis {axis} is the first that moves it otherwise"
    elif off[0]:  # in the zero pose
        where = "; every axis agrees, it is mounted elsewhere"
    raise ModelError(f"{what} is {by} off the D-H model {at}{where}")


def _off(position: Array, rotation: Array) -> np.ndarray:
    return (position > POSITION) | (rotation > ROTATION)


def _degrees(phi: Array) -> str:
    return f"({', '.join(f'{angle:.1f}' for angle in np.rad2deg(phi))}) deg"


def _shown(value: float) -> str:
    """Four digits, without the noise of rounding."""
    return f"{round(value, 9):.4g}"
