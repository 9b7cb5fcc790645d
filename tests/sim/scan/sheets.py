"""A small virtual sheet with a mark and an open kerf, and what was cut in truth."""

from collections.abc import Collection, Mapping
from pathlib import Path

import ezdxf
import numpy as np
from PIL import Image

from armside.sim.motion.contour import ClosedCurve, outward_normal
from armside.sim.part.arcs import MM, arc, line
from armside.sim.part.curve import ChainCurve
from armside.sim.scan.image import ScanImage
from armside.sim.scan.virtual import Process, Scanner, Sheet, scanned


def polygon(*points: tuple[float, float]) -> ChainCurve:
    """Closed, through points [mm]."""
    return ChainCurve(line(*(MM * np.array(points + points[:1]))))


def circle(x: float, y: float, radius: float) -> ChainCurve:
    """[mm]."""
    return ChainCurve(arc((x * MM, y * MM), radius * MM, 0.0, 2 * np.pi))


DRAWING: dict[str, ClosedCurve] = {
    "circle": circle(0, 0, 8),
    "square": polygon((14, -6), (26, -6), (26, 6), (14, 6)),
    "mark": circle(12, 9, 1.5),
    "kerf": ChainCurve(line((-6 * MM, 11 * MM), (6 * MM, 11 * MM))),
}
SIZE = (60 * MM, 60 * MM)
MIDDLE = np.array([9.0, 2.0]) * MM
"""Of the drawing; it lies in the middle of the image."""
IDEAL = Process(wave=0.0, roughness=0.0)


def deviation(name: str, s: np.ndarray) -> np.ndarray:
    """[m], by arc length: waves along circle, square and kerf of `DRAWING`, the last wanders by
    more than its width."""
    waves, size = {"circle": (3, 40e-6), "square": (4, 40e-6), "kerf": (2, 150e-6)}.get(
        name, (0, 0)
    )
    return size * np.sin(2 * np.pi * waves * s / DRAWING.get(name, circle(0, 0, 1)).length)


def cut(
    curve: ClosedCurve,
    d: np.ndarray | float,
    process: Process,
    rng: np.random.Generator,
    side: int = 1,
) -> np.ndarray:
    """Edge (N, 2) [m] of a curve that is cut d [m] outwards: d of the arc lengths `places(curve)`.

    side: 1 for a hole, -1 for a piece, 0 for an open kerf.
    """
    s = places(curve)
    path = curve.point(s) + np.reshape(d, (-1, 1)) * outward_normal(curve.tangent(s))
    return process.edge(path, side, rng) if side else process.kerf(path, rng)


def places(curve: ClosedCurve) -> np.ndarray:
    """Arc lengths 10 um apart [m]."""
    n = int(curve.length / 10e-6)
    return (np.arange(n) + 0.5) * curve.length / n


def image(
    degrees: float = 7.0,
    *,
    seed: int = 0,
    drawing: Mapping[str, ClosedCurve] = DRAWING,
    pieces: Collection[str] = (),
    process: Process = IDEAL,
    scanner: Scanner = Scanner(),
    greys: tuple[float, float] = (190.0, 40.0),
    mirrored: bool = False,
    middle: np.ndarray = MIDDLE,
    size: tuple[float, float] = SIZE,
    spots: tuple[tuple[float, float, float, float], ...] = (),
) -> ScanImage:
    """Scan of the sheet, turned about the drawing's middle. greys: of material and ground."""
    rng = np.random.default_rng(seed)
    regions = list[tuple[np.ndarray, bool]]()
    for name, curve in drawing.items():
        side = -1 if name in pieces else 0 if name == "kerf" else 1
        edge = cut(curve, deviation(name, places(curve)), process, rng, side)
        regions.append((edge, name in pieces))
    sheet = Sheet(
        regions=regions, everywhere=not pieces, material=greys[0], ground=greys[1], spots=spots
    )
    angle = np.radians(degrees)
    c, s = np.cos(angle), np.sin(angle)
    turned = np.array([[c, -s], [s, c]]) @ (middle * [-1.0 if mirrored else 1.0, 1.0])
    x, y = 0.5 * np.array(size) - turned
    return scanned(sheet, scanner, size, rng, place=(float(x), float(y), angle), mirrored=mirrored)


def save(seen: ScanImage, file: Path) -> Path:
    """The image as a scanner's program stores it."""
    Image.fromarray(seen.grey).save(file, dpi=seen.dpi)
    return file


def drawing_file(file: Path, drawing: Mapping[str, ClosedCurve] = DRAWING) -> Path:
    """Circles, polygons and lines as a DXF in mm."""
    document = ezdxf.new(units=4)
    space = document.modelspace()
    for curve in drawing.values():
        assert isinstance(curve, ChainCurve)
        points = curve.chain.points / MM
        if curve.chain.bulge.any():
            middle, radius = points[:2].mean(axis=0), 0.5 * np.linalg.norm(points[1] - points[0])
            space.add_circle(tuple(middle), float(radius))
        else:
            space.add_lwpolyline(
                points.tolist()[: -1 if curve.chain.closed else None], close=curve.chain.closed
            )
    document.saveas(file)
    return file
