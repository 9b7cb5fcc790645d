"""Poses of the IRB1400 by several toolboxes, on the motor angles of (5.13). Thesis 5.4.1."""

from contextlib import suppress

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import IRB1400
from armside.sim.cell import CELLS
from armside.sim.robot.model import load_model

from .peers import pinocchio_functions, toolbox_robot

MUJOCO, PINOCCHIO, TOOLBOX = (
    "MuJoCo, the closed chain",
    "Pinocchio",
    "Robotics Toolbox, used in the thesis",
)


def motor_angles() -> Array:
    """(60, 6) [rad]: one motor at a time, 1 to 3 by 0.4 and 4 to 6 by 0.5. Thesis (5.13)."""
    moved = [(i, tenths) for i in range(6) for tenths in range(-4 - (i > 2), 5 + (i > 2))]
    angles = np.zeros((len(moved), 6))
    for row, (i, tenths) in zip(angles, moved, strict=True):
        row[i] = tenths / 10
    return angles


def differences() -> dict[str, float | None]:
    """Largest difference of an entry of the pose from ours, by toolbox; None: not installed."""
    phi = motor_angles()
    ours = kinematics.compile(IRB1400).pose(phi)
    q = IRB1400.joint_variables(phi)
    found: dict[str, float | None] = {MUJOCO: _largest(_by_mujoco(phi) - ours)}
    found |= dict.fromkeys((PINOCCHIO, TOOLBOX))
    with suppress(ImportError):
        pose = pinocchio_functions(IRB1400).pose
        found[PINOCCHIO] = _largest(np.array([np.array(pose(each)) for each in q]) - ours)
    with suppress(ImportError):
        peer = toolbox_robot(IRB1400)
        offset = [float(link.theta) for link in IRB1400.links]
        found[TOOLBOX] = _largest(np.array([peer.fkine(each - offset).A for each in q]) - ours)
    return found


def _by_mujoco(phi: Array) -> Array:
    model = load_model(CELLS["irb1400"].xml)
    data = mujoco.MjData(model.mj)
    T = np.tile(np.eye(4), (len(phi), 1, 1))
    for pose, angles in zip(T, phi, strict=True):
        data.qpos[:] = model.posture @ angles
        mujoco.mj_kinematics(model.mj, data)
        pose[:3, :3] = data.site("tool0").xmat.reshape(3, 3)
        pose[:3, 3] = data.site("tool0").xpos
    return T


def _largest(difference: Array) -> float:
    return float(np.abs(difference).max())
