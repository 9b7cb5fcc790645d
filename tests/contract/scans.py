"""Images that no deviation may be read from: damaged, wrong, mirrored, cropped, coarse, too bright
or of something else."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from PIL import Image
from tests.sim.scan.sheets import circle, drawing_file, image, polygon, save

from armside.sim.motion.contour import ClosedCurve
from armside.sim.part.arcs import MM
from armside.sim.scan.image import ScanImage
from armside.sim.scan.virtual import Process, Scanner

SIZE = (44 * MM, 40 * MM)
MIDDLE = np.array([6.0, 2.0]) * MM
Drawn = dict[str, ClosedCurve]


class Case(NamedTuple):
    """A command line's files."""

    image: Path
    drawing: Path


def drawing(rng: Generator, scale: float = 1.0, moved: float = 0.0) -> Drawn:
    """A circle, a square and a mark; the square is off its place by `moved` [mm]."""
    r, half, mark = scale * rng.uniform([4.0, 3.0, 1.0], [6.0, 4.5, 1.5])
    x = scale * 13.0 + moved
    corners = [(x + i * half, j * half) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return {
        "a": circle(0, 0, r),
        "b": polygon(*corners),
        "mark": circle(scale * 6.0, scale * 7.0, mark),
    }


def sheet(rng: Generator, of: Drawn, **options) -> ScanImage:
    """A good scan of it."""
    seed, degrees = int(rng.integers(1 << 31)), rng.uniform(-180.0, 180.0)
    given = {"middle": MIDDLE, "size": SIZE, "process": Process()} | options
    return image(degrees, seed=seed, drawing=of, **given)


def damaged_file(rng: Generator, of: Drawn, file: Path) -> None:
    save(sheet(rng, of), file)
    data = bytearray(file.read_bytes())
    match rng.integers(4):
        case 0:
            data = data[: int(rng.uniform(0.0, 0.9) * len(data))]
        case 1:  # in the pixels: after the head, before the end
            for at in rng.integers(200, len(data) - 200, 20):
                data[at] ^= int(rng.integers(1, 256))
        case 2:
            data[: int(rng.integers(1, 8))] = b"?" * 8
        case _:
            data = bytearray(b"contour,arc_length\n1,2\n" * int(rng.integers(1, 50)))
    file.write_bytes(bytes(data))


def damaged_sheet(rng: Generator, of: Drawn, file: Path) -> None:
    """Half of a contour or more is covered."""
    seen = sheet(rng, of)
    grey = seen.grey.copy()
    rows, columns = grey.shape
    band = int(rng.uniform(0.35, 0.6) * rows)
    top = int(rng.uniform(0.25, 0.4) * rows)
    grey[top : top + band] = rng.normal(rng.uniform(60, 200), 3.0, (band, columns)).clip(0, 255)
    save(replace(seen, grey=grey), file)


def wrong(rng: Generator, of: Drawn, file: Path) -> None:
    again = np.random.default_rng(rng.integers(1 << 31))
    if rng.integers(2):
        save(sheet(rng, drawing(again)), file)
        return
    side = rng.choice([-1.0, 1.0])
    moved = of["b"].point(np.arange(4) * of["b"].length / 4) / MM
    moved[:, 0] += side * rng.uniform(2.0, 4.0)
    corners = [(float(x), float(y)) for x, y in moved]
    save(sheet(rng, of | {"b": polygon(*corners)}), file)


def mirrored_without_mark(rng: Generator, of: Drawn, file: Path) -> None:
    save(sheet(rng, of, mirrored=True), file)


def cropped(rng: Generator, of: Drawn, file: Path) -> None:
    seen = sheet(rng, of)
    rows, columns = seen.grey.shape
    part = rng.uniform(0.3, 0.6)
    box = [slice(None), slice(None)]
    axis = int(rng.integers(2))
    n = int(part * seen.grey.shape[axis])
    box[axis] = slice(n) if rng.integers(2) else slice((rows, columns)[axis] - n, None)
    save(replace(seen, grey=seen.grey[tuple(box)]), file)


def coarse(rng: Generator, of: Drawn, file: Path) -> None:
    """Few pixels, also where they were made many afterwards."""
    seen = sheet(rng, of, scanner=Scanner(dpi=600.0))
    n = int(rng.integers(3, 12))
    small = Image.fromarray(seen.grey).reduce(n)
    if rng.integers(2):
        small.save(file, dpi=(600.0 / n, 600.0 / n))
    else:
        rows, columns = seen.grey.shape
        small.resize((columns, rows), Image.Resampling.BICUBIC).save(file, dpi=(600.0, 600.0))


def over_exposed(rng: Generator, of: Drawn, file: Path) -> None:
    bright, dark = rng.uniform(275.0, 500.0), rng.uniform(30.0, 400.0)
    greys = (bright, dark) if rng.integers(2) else (dark, bright)
    save(sheet(rng, of, greys=greys), file)


def unrelated(rng: Generator, _of: Drawn, file: Path) -> None:
    rows, columns = rng.integers(400, 1600, 2)
    y, x = np.mgrid[:rows, :columns]
    match rng.integers(5):
        case 0:
            grey = rng.integers(0, 256, (rows, columns))
        case 1:
            grey = np.full((rows, columns), rng.integers(256))
        case 2:
            grey = 255 * x / columns
        case 3:  # blobs
            grey = np.full((rows, columns), 40.0)
            for _ in range(rng.integers(1, 60)):
                cx, cy, r = rng.uniform([0, 0, 5], [columns, rows, 200])
                grey[np.hypot(x - cx, y - cy) < r] = rng.uniform(0, 255)
        case _:  # stripes, as of print
            grey = 128 + 100 * np.sign(np.sin(x / rng.uniform(3, 40)) * np.sin(y / 20.0))
    Image.fromarray(grey.astype(np.uint8)).save(file, dpi=(1200, 1200))


KINDS: dict[str, Callable[[Generator, Drawn, Path], None]] = {
    make.__name__: make
    for make in (
        damaged_file,
        damaged_sheet,
        wrong,
        mirrored_without_mark,
        cropped,
        coarse,
        over_exposed,
        unrelated,
    )
}


def case(number: int, folder: Path) -> Case:
    """Files of one case, by its number: each kind in turn."""
    rng = np.random.default_rng(number)
    kind = list(KINDS)[number % len(KINDS)]
    of = drawing(rng)
    if kind == "mirrored_without_mark":
        del of["mark"]
    suffix = "tiff" if rng.integers(4) == 0 and kind != "damaged_file" else "png"
    found = Case(folder / f"{kind}.{suffix}", folder / "sheet.dxf")
    KINDS[kind](rng, of, found.image)
    drawing_file(found.drawing, of)
    return found
