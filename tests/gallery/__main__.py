"""`python -m tests.gallery [NAME ...]`: the pictures of the docs, made again from seeds.

`make pictures` calls it. A picture is a file with a function `draw(run, file)`: of the folder of
the default run, and of the file to write. `replay` needs Chromium and its driver; `robots` and
`picture` need OpenGL (EGL).
"""

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from armside.scripts.cli import main as armside
from armside.scripts.shell.errors import InputError, RunFailed

from .. import evidence

IMAGES = Path("docs") / "images"
WIDEST = 1200
"""Largest width of a picture in the docs [pixels]."""
COLOURS = 256
"""Size of a picture's palette: drawings lose nothing by it."""


def main(words: Sequence[str] | None = None) -> int:
    """Draw the pictures, and print their sizes."""
    parser = argparse.ArgumentParser(prog="python -m tests.gallery", description=__doc__)
    parser.add_argument("names", nargs="*", help="pictures [default: all]")
    parser.add_argument("--images", type=Path, default=IMAGES, help="folder to write to")
    asked = parser.parse_args(words)
    names = evidence.chosen("gallery", asked.names)
    with tempfile.TemporaryDirectory(prefix="armside-") as folder:
        run = Path(folder) / "run"
        if status := armside(["laser", "--quiet", "--out", str(run)]):
            return status
        for name in names:
            raw = Path(folder) / f"{name}.png"
            try:
                evidence.module("gallery", name).draw(run, raw)
            except (InputError, RunFailed) as error:
                print(f"{name}: {error}", file=sys.stderr)
                return 1
            asked.images.mkdir(parents=True, exist_ok=True)
            size = shrink(raw, asked.images / f"{name}.png")
            print(f"{asked.images / name}.png: {size // 1000} kB")
    return 0


def shrink(raw: Path, file: Path) -> int:
    """Write a picture at the size of the docs; returns its size in bytes."""
    with Image.open(raw) as image:
        picture = image.convert("RGB")
    if picture.width > WIDEST:
        height = round(picture.height * WIDEST / picture.width)
        picture = picture.resize((WIDEST, height), Image.Resampling.LANCZOS)
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(file, format="PNG", optimize=True)
    return file.stat().st_size


if __name__ == "__main__":
    sys.exit(main())
