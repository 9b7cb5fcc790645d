"""Pictures of the docs, each from the folder of the default run."""

import io
import shutil
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from PIL import Image

from ..shell.errors import InputError, RunFailed

WIDEST = 1200
"""Largest width of a picture in the docs [pixels]."""
COLOURS = 256
"""Size of a picture's palette: drawings lose nothing by it."""
DRAWING_TIME = 120.0
"""Longest wait for the browser to draw the replay on the CPU [s]."""
HOUSE = ((-10.0, -6.0), (10.0, -6.0), (10.0, 6.0), (0.0, 9.0), (-10.0, 6.0))
"""[mm], corners of the part in docs/examples/house.toml."""
LAYOUT_TIME = 4.0
"""Wait for the browser to lay out the text as well [s]."""


def shrink(raw: Path, file: Path) -> int:
    """Write a picture at the size of the docs; returns its size in bytes."""
    with Image.open(raw) as image:
        picture = image.convert("RGB")
    if picture.width > WIDEST:
        height = round(picture.height * WIDEST / picture.width)
        picture = picture.resize((WIDEST, height), Image.Resampling.LANCZOS)
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(file, format="PNG", optimize=True)
    return file.stat().st_size


def picture(run: Path, file: Path) -> None:
    """Robot of the run, and its tool's path."""
    from armside.sim.records import read_run
    from armside.sim.replay import film

    film.picture(file, [film.stored_shots(read_run(run))])


def robots(_run: Path, file: Path) -> None:
    """Both robots in their zero pose."""
    import mujoco

    from armside.sim.cell import CELLS
    from armside.sim.replay.offscreen import Offscreen, drawn_model, named_camera

    both = Image.new("RGB", (1200, 500))
    for i, cell in enumerate(CELLS.values()):
        mj = drawn_model(mujoco.MjModel.from_xml_path(str(cell.xml)), cell.xml)
        data = mujoco.MjData(mj)
        mujoco.mj_forward(mj, data)
        with Offscreen(mj, 600, 500) as camera:
            drawn = Image.fromarray(camera.draw(data, named_camera(mj, "whole")))
        both.paste(drawn, (600 * i, 0))
    both.save(file)


def replay(run: Path, file: Path) -> None:
    """Replay of the run in Chromium.

    Raises InputError without Chromium and its driver, RunFailed where nothing is drawn in time.
    """
    from ..viewers.browser import page
    from ..viewers.web_viewer import WebViewer

    viewer = WebViewer(run / "replay.rrd", port=0)
    thread = threading.Thread(target=viewer.serve)
    thread.start()
    try:
        with page(f"{viewer.address}?renderer=webgl", height=1000) as shown:
            shown.screenshot_when(_is_drawn, DRAWING_TIME)
            time.sleep(LAYOUT_TIME)
            png = shown.screenshot()
    except OSError as error:
        raise InputError(f"replay needs chromium and chromedriver: {error}") from error
    finally:
        viewer.close()
        thread.join()
    if not _is_drawn(png):
        raise RunFailed(f"the browser drew nothing within {DRAWING_TIME:g} s")
    file.write_bytes(png)


def _is_drawn(png: bytes) -> bool:
    """Robot and tool path (orange) and motors' path (blue) are on the page."""
    with Image.open(io.BytesIO(png)) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    r, g, b = (pixels[..., i] for i in range(3))
    left, middle = slice(0, pixels.shape[1] // 4), slice(pixels.shape[1] // 3, None)
    orange, blue = (r > 150) & (b < 90) & (r - g > 60), (b > 150) & (b - r > 90)
    drawn = (orange[:, left].sum(), orange[:, middle].sum(), blue[:, middle].sum())
    return bool(min(drawn) > 500)


def first_cut(_run: Path, file: Path) -> None:
    """A part that a robot never cut: uncorrected, by its twin of four cuts, and after learning."""
    from armside.sim.cell import TOOL_QUATERNION, ToolPose
    from armside.sim.laser.specification import Cut
    from armside.sim.motion.contour_file import rounded
    from armside.sim.robot.spread import Drawn

    from .first_cut import draw

    place = ToolPose((1.6, 0.35, 1.4), TOOL_QUATERNION)
    part = Cut(pose=place, contour=rounded(1e-3 * np.array(HOUSE), 1.5e-3), speed=0.040)
    draw(file, part, Drawn(1004), cuts=4)


PICTURES: Mapping[str, Callable[[Path, Path], object]] = {
    "first-cut": first_cut,
    "circles": lambda run, file: shutil.copy(run / "circles.png", file),
    "errors": lambda run, file: shutil.copy(run / "errors.png", file),
    "picture": picture,
    "robots": robots,
    "replay": replay,
}
"""Pictures by the name of the file: each takes the run's folder and the file to write."""
