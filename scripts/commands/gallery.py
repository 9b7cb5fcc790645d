"""`armside gallery`: the pictures of the docs, made again from seeds."""

import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from PIL import Image

from armside.sim.records.summary import summary

from ..shell.console import Report, keep
from ..shell.errors import InputError, RunFailed
from ..shell.options import Common, options
from ..shell.registry import unknown

IMAGES = Path("docs") / "images"
WIDEST = 1200
"""[pixels], of a picture in the docs."""
COLOURS = 256
"""Of a picture's palette: drawings lose nothing by it."""
PATIENCE = 120.0
"""For the browser to draw the replay on the CPU [s]."""
SETTLING = 4.0
"""After which the browser has laid out the text as well [s]."""


@options
@dataclass(frozen=True, kw_only=True)
class GalleryCfg:
    """Where to put the pictures."""

    images: Path = IMAGES
    """Folder to write to."""


def gallery(
    *names: Annotated[str, Parameter(help="Which pictures [default: all].")],
    cfg: GalleryCfg = GalleryCfg(),
    common: Common = Common(),
) -> None:
    """Make the pictures of the docs again: runs, robots, the replay in a browser.

    `replay` needs Chromium and its driver; `robots` and `picture` need OpenGL (EGL).
    """
    report = Report(common)
    for name in names:
        if name not in PICTURES:
            raise unknown("picture", name, PICTURES)
    chosen = list(names or PICTURES)
    cfg.images.mkdir(parents=True, exist_ok=True)
    made: dict[str, int] = {}
    with (
        tempfile.TemporaryDirectory(prefix="armside-") as folder,
        report.progress("drawing", total=len(chosen)) as step,
    ):
        for name in chosen:
            raw = Path(folder) / f"{name}.png"
            PICTURES[name](raw, common.seed)
            made[name] = shrink(raw, cfg.images / f"{name}.png")
            step()
    report.table(
        f"Pictures in {cfg.images}", ["name", "kB"], [(n, size // 1000) for n, size in made.items()]
    )
    outcome = summary("gallery", cfg, common, bytes=made)
    keep(outcome, common)
    report.summary(outcome)


def shrink(raw: Path, file: Path) -> int:
    """Write a picture small, as docs need it; returns its size in bytes."""
    with Image.open(raw) as image:
        picture = image.convert("RGB")
    if picture.width > WIDEST:
        height = round(picture.height * WIDEST / picture.width)
        picture = picture.resize((WIDEST, height), Image.Resampling.LANCZOS)
    palette = picture.quantize(COLOURS, dither=Image.Dither.NONE)
    palette.save(file, format="PNG", optimize=True)
    return file.stat().st_size


def circles(file: Path, seed: int) -> None:
    """The tool's path in each iteration of the default run."""
    with tempfile.TemporaryDirectory(prefix="armside-") as folder:
        run = _run(Path(folder) / "run", seed)
        file.write_bytes((run / "circles.png").read_bytes())


def errors(file: Path, seed: int) -> None:
    """Motor and tool errors of the default run."""
    with tempfile.TemporaryDirectory(prefix="armside-") as folder:
        run = _run(Path(folder) / "run", seed)
        file.write_bytes((run / "errors.png").read_bytes())


def picture(file: Path, seed: int) -> None:
    """The robot of the default run, and its tool's path."""
    from .replay import ReplayCfg, replay

    with tempfile.TemporaryDirectory(prefix="armside-") as folder:
        run = _run(Path(folder) / "run", seed)
        replay(run, cfg=ReplayCfg(png=file), common=Common(quiet=True))


def robots(file: Path, seed: int) -> None:
    """Both robots in their zero pose."""
    import mujoco

    from armside.sim.cell import CELLS
    from armside.sim.replay.offscreen import Offscreen, drawn_model, named_camera

    images = []
    for cell in CELLS.values():
        mj = drawn_model(mujoco.MjModel.from_xml_path(str(cell.xml)), cell.xml)
        data = mujoco.MjData(mj)
        mujoco.mj_forward(mj, data)
        with Offscreen(mj, 600, 500) as camera:
            images.append(Image.fromarray(camera.draw(data, named_camera(mj, "whole"))))
    both = Image.new("RGB", (1200, 500))
    for i, image in enumerate(images):
        both.paste(image, (600 * i, 0))
    both.save(file)


def replay_in_browser(file: Path, seed: int) -> None:
    """The replay of the default run, as Chromium shows it."""
    from ..viewers.browser import page
    from ..viewers.web_viewer import WebViewer

    with tempfile.TemporaryDirectory(prefix="armside-") as folder:
        run = _run(Path(folder) / "run", seed)
        viewer = WebViewer(run / "replay.rrd", port=0)
    thread = threading.Thread(target=viewer.serve)
    thread.start()
    try:
        with page(f"{viewer.address}?renderer=webgl", height=1000) as shown:
            shown.screenshot_when(_is_drawn, PATIENCE)
            time.sleep(SETTLING)
            seen = shown.screenshot()
    except OSError as error:
        raise InputError(f"replay needs chromium and chromedriver: {error}") from error
    finally:
        viewer.close()
        thread.join()
    if not _is_drawn(seen):
        raise RunFailed(f"the browser drew nothing within {PATIENCE:g} s")
    file.write_bytes(seen)


def _is_drawn(png: bytes) -> bool:
    """There are robot and tool path (orange) and motors' path (blue) on the page."""
    import io

    import numpy as np

    with Image.open(io.BytesIO(png)) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    r, g, b = (pixels[..., i] for i in range(3))
    left, middle = slice(0, pixels.shape[1] // 4), slice(pixels.shape[1] // 3, None)
    orange, blue = (r > 150) & (b < 90) & (r - g > 60), (b > 150) & (b - r > 90)
    drawn = (orange[:, left].sum(), orange[:, middle].sum(), blue[:, middle].sum())
    return bool(min(drawn) > 500)


def _run(out: Path, seed: int) -> Path:
    from .laser import laser

    laser(common=Common(seed=seed, out=out, quiet=True))
    return out


PICTURES: dict[str, Callable[[Path, int], None]] = {
    "circles": circles,
    "errors": errors,
    "picture": picture,
    "robots": robots,
    "replay": replay_in_browser,
}
"""By the name of the file."""
