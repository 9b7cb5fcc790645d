"""Geometry of an MJCF beside the Denavit-Hartenberg table of its controller; refused if another.

The controller plans with the D-H table. A model of another geometry runs all the same, and cuts
beside the place.
"""

from pathlib import Path

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import Limits, Robot

from ..cell import Cell
from .linkage import LARGEST_GAP, Linkage
from .mjcf import ModelError
from .model import RobotModel, load_model

CONFIGURATIONS = 100
"""Random motor angles that are drawn; those within the limits are compared."""
TOOL = "tool0"


def configurations(limits: Limits) -> Array:
    """(K, n) [rad], the zero pose and random motor angles, the same for every model."""
    rng = np.random.default_rng(0)
    drawn = rng.uniform(limits.lower, limits.upper, (CONFIGURATIONS, len(limits.lower)))
    return np.vstack((np.zeros(len(limits.lower)), drawn[limits.contain(drawn)]))


def site_poses(model: RobotModel, phi: Array, site: str = TOOL) -> tuple[Array, Array]:
    """(K, 4, 4) base to site at motor angles (K, n) with every spring at zero, and (K,) [m], how
    far the cuts of closed chains are open there."""
    mj, data = model.mj, mujoco.MjData(model.mj)
    index, linkage = mj.site(site).id, Linkage(model.mj)
    T, opening = np.tile(np.eye(4), (len(phi), 1, 1)), np.zeros(len(phi))
    for i, q in enumerate(phi @ model.posture.T):
        data.qpos[:] = q
        mujoco.mj_kinematics(mj, data)
        T[i, :3, 3] = data.site_xpos[index]
        T[i, :3, :3] = data.site_xmat[index].reshape(3, 3)
        if not linkage.is_open:
            opening[i] = np.abs(linkage.gap(data)).max()
    return T, opening


def between(T: Array, other: Array) -> tuple[Array, Array]:
    """Distance [m] and rotation angle [rad], (K,) each, between poses (K, 4, 4)."""
    position = np.linalg.norm(T[:, :3, 3] - other[:, :3, 3], axis=1)
    # |R - R'| = sqrt(8) sin(angle / 2), exact for small angles too.
    apart = np.linalg.norm(T[:, :3, :3] - other[:, :3, :3], axis=(1, 2)) / np.sqrt(8.0)
    return position, 2.0 * np.arcsin(np.minimum(apart, 1.0))


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

    Compared in the zero pose and at random motor angles within their ranges, every spring at zero
    and closed chains closed. with_imu: D-H model whose last frame is the site imu.
    """
    n = model.posture.shape[1]
    if not n == robot.n_joints == len(limits.lower):
        raise ModelError(
            f"the model has {n} axes, the D-H model {robot.name} {robot.n_joints} and its limits "
            f"{len(limits.lower)}: they must be as many"
        )
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

    Each moves alone; its motion T T_0^-1 in base axes does not depend on how the tool is mounted.
    """
    alone = np.vstack((np.zeros(robot.n_joints), STEP * np.eye(robot.n_joints)))
    ours, theirs = site_poses(model, alone)[0], kinematics.compile(robot).pose(alone)
    motion, expected = ours[1:] @ np.linalg.inv(ours[0]), theirs[1:] @ np.linalg.inv(theirs[0])
    differ = np.flatnonzero(_off(*between(motion, expected)))
    return int(differ[0]) + 1 if len(differ) else None


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


def cell_model(cell: Cell, source: Path | mujoco.MjModel | None = None) -> RobotModel:
    """Robot model that agrees with the cell's D-H model, or ModelError with the file.

    source: MJCF file in place of the cell's own, or a compiled variant of that.
    """
    source = cell.xml if source is None else source
    model = load_model(source)
    try:
        check_kinematics(model, cell.robot, cell.limits, cell.with_imu)
    except ModelError as error:
        file = source if isinstance(source, Path) else cell.xml
        raise ModelError(f"{file}: {error}") from error
    return model
