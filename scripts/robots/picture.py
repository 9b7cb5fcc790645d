"""Picture of a robot at its home, without a window."""

from pathlib import Path

import mujoco
import numpy as np

from armside.arrays import Array
from armside.sim.cell import Cell
from armside.sim.replay.offscreen import Offscreen, drawn_model, named_camera
from armside.sim.robot.model import RobotModel

WIDTH, HEIGHT = 960, 720


def draw_robot(file: Path, model: RobotModel, cell: Cell) -> None:
    """Write a PNG. Raises NoGraphicsError where nothing can be drawn."""
    import matplotlib.image

    mj = drawn_model(model.mj, cell.xml)
    data = mujoco.MjData(mj)
    for i, angle in enumerate(_home(cell), 1):
        data.qpos[mj.joint(f"motor_{i}").qposadr[0]] = angle
    mujoco.mj_forward(mj, data)
    with Offscreen(mj, WIDTH, HEIGHT) as screen:
        matplotlib.image.imsave(file, screen.draw(data, named_camera(mj, "overview")))


def _home(cell: Cell) -> Array:
    zero = np.zeros(cell.robot.n_joints)
    home = zero if cell.home is None else np.array(cell.home)
    return np.clip(home, cell.limits.lower, cell.limits.upper)
