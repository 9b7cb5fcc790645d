"""Forward kinematics of an MJCF against the Denavit-Hartenberg model of its controller.

The controller plans with the D-H table. A model of another geometry runs all the same, and cuts
beside the place.
"""

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import Limits, Robot

from .mjcf import ModelError
from .model import RobotModel

CONFIGURATIONS = 100
POSITION = 1e-5
"""Largest difference of the tool's position [m]: what a program resolves."""
ROTATION = 1e-5
"""Largest difference of its orientation [rad]."""


def check_kinematics(model: RobotModel, robot: Robot, limits: Limits) -> None:
    """Raise ModelError unless the tool of the MJCF is where the D-H model has it.

    Compared in the zero pose and at random motor angles within their ranges; the message has the
    largest difference and its place.
    """
    phi = configurations(limits)
    position, rotation = differences(model, robot, phi)
    if (position <= POSITION).all() and (rotation <= ROTATION).all():
        return
    worst = int(np.argmax(position / POSITION + rotation / ROTATION))
    angles = ", ".join(f"{a:.1f}" for a in np.rad2deg(phi[worst]))
    raise ModelError(
        f"the model is no {robot.name}: its tool is {1e3 * position[worst]:.4g} mm and "
        f"{np.rad2deg(rotation[worst]):.3f} deg off the D-H model at motor angles ({angles}) deg"
    )


def configurations(limits: Limits) -> Array:
    """(K, n) [rad], the zero pose and random motor angles, the same for every model."""
    rng = np.random.default_rng(0)
    drawn = rng.uniform(limits.lower, limits.upper, (CONFIGURATIONS, len(limits.lower)))
    return np.vstack((np.zeros(len(limits.lower)), drawn[limits.contain(drawn)]))


def differences(model: RobotModel, robot: Robot, phi: Array) -> tuple[Array, Array]:
    """Distance [m] and rotation angle [rad], (K,) each, between both tools at angles (K, 6)."""
    T_base_tool = kinematics.compile(robot).pose(np.ascontiguousarray(phi))
    data, site = mujoco.MjData(model.mj), model.mj.site("tool0").id
    position, rotation = np.empty((2, len(phi)))
    for i, q in enumerate(phi @ model.posture.T):
        data.qpos[:] = q
        mujoco.mj_kinematics(model.mj, data)
        R = data.site_xmat[site].reshape(3, 3)
        position[i] = np.linalg.norm(data.site_xpos[site] - T_base_tool[i, :3, 3])
        # |R - R'| = sqrt(8) sin(angle / 2), exact for small angles too.
        apart = np.linalg.norm(R - T_base_tool[i, :3, :3]) / np.sqrt(8.0)
        rotation[i] = 2.0 * np.arcsin(min(float(apart), 1.0))
    return position, rotation
