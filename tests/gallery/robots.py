"""Both robots of the thesis in their zero pose."""

from pathlib import Path

import mujoco
from PIL import Image, ImageDraw, ImageFont

from armside.sim.cell import CELLS
from armside.sim.replay.offscreen import Offscreen, drawn_model, named_camera

LINE = ""
SEED = "none"
NAMES = {"large": "Large robot", "irb1400": "IRB1400"}


def draw(_run: Path, file: Path) -> list[bytes]:
    both = Image.new("RGB", (1200, 500))
    for i, (name, cell) in enumerate(CELLS.items()):
        mj = drawn_model(mujoco.MjModel.from_xml_path(str(cell.xml)), cell.xml)
        data = mujoco.MjData(mj)
        mujoco.mj_forward(mj, data)
        with Offscreen(mj, 600, 500) as camera:
            drawn = Image.fromarray(camera.draw(data, named_camera(mj, "whole")))
        both.paste(drawn, (600 * i, 0))
        pen, place = ImageDraw.Draw(both), (600 * i + 20, 14)
        pen.text(place, NAMES[name], "black", ImageFont.load_default(22))
    both.save(file)
    return [cell.xml.read_bytes() for cell in CELLS.values()]
