"""Replay of the run in Chromium."""

import io
import threading
import time
from pathlib import Path

import numpy as np
from PIL import Image

from armside.scripts.shell.errors import InputError, RunFailed
from armside.scripts.viewers.web_viewer import WebViewer

from ._browser import page

LINE = "laser"
DRAWING_TIME = 120.0
"""Longest wait for the browser to draw the replay on the CPU [s]."""
LAYOUT_TIME = 4.0
"""Wait for the browser to lay out the text as well [s]."""


def draw(run: Path, file: Path) -> None:
    """Raises InputError without Chromium and its driver, RunFailed where nothing is drawn."""
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
