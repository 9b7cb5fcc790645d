"""Forward kinematics of an MJCF against the Denavit-Hartenberg model of its controller."""

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import Limits, Robot

from .linkage import Linkage
from .model import RobotModel

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


def differences(
    model: RobotModel, robot: Robot, phi: Array, site: str = TOOL
) -> tuple[Array, Array]:
    """Distance [m] and rotation angle [rad], (K,) each, between a site and the last frame of the
    D-H model at motor angles (K, n)."""
    T_base_tool = kinematics.compile(robot).pose(np.ascontiguousarray(phi))
    return between(site_poses(model, phi, site)[0], T_base_tool)
