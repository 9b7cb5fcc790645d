"""`python -m tests.gallery [NAME ...]`: the pictures of the docs, made again from seeds.

`make pictures` calls it. A picture is a file with `LINE`, the line of armside that it is drawn from
or "", and either `DRAWN`, a PNG that this line writes, or `draw(run, file)`: of the folder of that
line, and of the file to write; what draw returns are its data, by default those of the line. Text
chunks of each PNG say what made it, and results.json says the same. `replay` needs Chromium and its
driver; `robots` needs OpenGL (EGL).
"""

import argparse
import shutil
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from PIL import Image

from armside.scripts.cli import main as armside
from armside.scripts.shell.errors import InputError, RunFailed

from .. import evidence
from ..pages._engine import results, store
from ..pages._pictures import drawn, of_folder, picture, stamp

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

        @cache
        def run(line: str) -> Path:
            out = Path(folder) / line.replace(" ", "-")
            if armside([*line.split(), "--quiet", "--out", str(out)]):
                raise RunFailed(f"armside {line}")
            return out

        for name in names:
            raw, module = Path(folder) / f"{name}.png", evidence.module("gallery", name)
            try:
                of = run(module.LINE) if module.LINE else Path(folder)
                if hasattr(module, "DRAWN"):
                    shutil.copy(of / module.DRAWN, raw)
                    data = None
                else:
                    data = module.draw(of, raw)
            except (InputError, RunFailed) as error:
                print(f"{name}: {error}", file=sys.stderr)
                return 1
            asked.images.mkdir(parents=True, exist_ok=True)
            file = asked.images / f"{name}.png"
            shrink(raw, file)
            found = drawn(picture(name), file, of_folder(of) if data is None else data)
            stamp(file, found)
            if asked.images == IMAGES:
                store(results() | {file.name: found})
            print(f"{file}: {file.stat().st_size // 1000} kB")
    return 0


def shrink(raw: Path, file: Path) -> None:
    """Write a picture at the size of the docs."""
    with Image.open(raw) as image:
        picture = image.convert("RGB")
    if picture.width > WIDEST:
        height = round(picture.height * WIDEST / picture.width)
        picture = picture.resize((WIDEST, height), Image.Resampling.LANCZOS)
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(file, format="PNG", optimize=True)


if __name__ == "__main__":
    sys.exit(main())
