"""Time and memory of reading a scan of a whole A4 bed."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from armside.sim.part.arcs import MM, Chain, arc, line
from armside.sim.part.curve import ChainCurve
from armside.sim.scan.image import read_image
from armside.sim.scan.reading import read_scan
from armside.sim.scan.virtual import Process, Scanner, Sheet, scanned

from ._timing import Row, peak_memory, timed

BED = (210 * MM, 297 * MM)
DPI = 1200.0
MARK, KERF = "mark", "kerf"


def measured() -> Sequence[Row]:
    """A PNG of 9921 x 14031 pixels with ten contours; the peak is of this process, in GB."""
    drawing = sheet()
    with TemporaryDirectory() as folder:
        file = Path(folder) / "a4.png"
        store(file, drawing)
        rows = timed(
            {f"A4 at {DPI:g} dpi read, {len(drawing)} contours": lambda: read(file, drawing)},
            repeats=1,
        )
    return [*rows, Row("the same, peak memory [GB]", peak_memory())]


def sheet() -> dict[str, ChainCurve]:
    """Eight circles and squares over an A4 bed, a mark and an open kerf."""
    found = dict[str, ChainCurve]()
    for i in range(8):
        x, y = (50.0 + 90.0 * (i % 2)) * MM, (45.0 + 65.0 * (i // 2)) * MM
        half = (12.0 + i) * MM
        if i % 3:
            found[f"circle {i}"] = ChainCurve(arc((x, y), half, 0.0, 2.0 * np.pi))
        else:
            corners = [(x + a * half, y + b * half) for a, b in SQUARE]
            found[f"square {i}"] = ChainCurve(Chain(np.array(corners), np.zeros(4)))
    found[MARK] = ChainCurve(arc((95.0 * MM, 70.0 * MM), 3.0 * MM, 0.0, 2.0 * np.pi))
    found[KERF] = ChainCurve(line((80.0 * MM, 272.0 * MM), (120.0 * MM, 272.0 * MM)))
    return found


SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))


def store(file: Path, drawing: dict[str, ChainCurve]) -> None:
    """Its scan, turned by 2 degrees about the middle of the bed."""
    rng, process, regions = np.random.default_rng(0), Process(), []
    for name, curve in drawing.items():
        path = curve.point(np.arange(0.0, curve.length, 20e-6))
        edge = process.kerf(path, rng) if name == KERF else process.edge(path, 1, rng)
        regions.append((edge, False))
    angle = np.radians(2.0)
    c, s = np.cos(angle), np.sin(angle)
    middle = 0.5 * np.array(BED)
    x, y = middle - np.array([[c, -s], [s, c]]) @ middle
    place = (float(x), float(y), float(angle))
    seen = scanned(Sheet(regions=regions), Scanner(dpi=DPI), BED, rng, place=place)
    Image.fromarray(seen.grey).save(file, dpi=seen.dpi, compress_level=1)


def read(file: Path, drawing: dict[str, ChainCurve]) -> None:
    read_scan(read_image(file), drawing)
