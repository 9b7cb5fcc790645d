"""Both robots of the thesis in their zero pose."""

from pathlib import Path

import mujoco
from PIL import Image

from armside.sim.cell import CELLS
from armside.sim.replay.offscreen import Offscreen, drawn_model, named_camera


def draw(_run: Path, file: Path) -> None:
    both = Image.new("RGB", (1200, 500))
    for i, cell in enumerate(CELLS.values()):
        mj = drawn_model(mujoco.MjModel.from_xml_path(str(cell.xml)), cell.xml)
        data = mujoco.MjData(mj)
        mujoco.mj_forward(mj, data)
        with Offscreen(mj, 600, 500) as camera:
            drawn = Image.fromarray(camera.draw(data, named_camera(mj, "whole")))
        both.paste(drawn, (600 * i, 0))
    both.save(file)
