"""Picture of a robot at its home, without a window."""

import copy
from pathlib import Path

import mujoco
import numpy as np

from armside.arrays import Array
from armside.sim.cell import Cell
from armside.sim.replay.offscreen import Offscreen, drawn_model, named_camera
from armside.sim.robot.model import RobotModel

WIDTH, HEIGHT = 960, 720
AMBIENT, DIFFUSE = 0.35, 0.6
"""Light at the camera, of a robot without a scene beside its file."""


def draw_robot(file: Path, model: RobotModel, cell: Cell) -> None:
    """Write a PNG. Raises NoGraphicsError where nothing can be drawn."""
    import matplotlib.image

    mj = drawn_model(model.mj, cell.xml)
    alone = mj is model.mj
    if alone:
        mj = copy.copy(mj)
        mj.vis.headlight.ambient[:], mj.vis.headlight.diffuse[:] = AMBIENT, DIFFUSE
    data = mujoco.MjData(mj)
    for i, angle in enumerate(_home(cell), 1):
        data.qpos[mj.joint(f"motor_{i}").qposadr[0]] = angle
    mujoco.mj_forward(mj, data)
    with Offscreen(mj, WIDTH, HEIGHT) as screen:
        image = screen.draw(data, named_camera(mj, "overview"))
    if alone:  # nothing is behind it: black, which no lit shape is
        image = np.where(image.any(axis=2, keepdims=True), image, np.uint8(255))
    matplotlib.image.imsave(file, image)


def _home(cell: Cell) -> Array:
    zero = np.zeros(cell.robot.n_joints)
    home = zero if cell.home is None else np.array(cell.home)
    return np.clip(home, cell.limits.lower, cell.limits.upper)
