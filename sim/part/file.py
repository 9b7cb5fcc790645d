"""Parts from files: DXF, SVG, and contours in TOML."""

from pathlib import Path

import numpy as np

from ..cut.contour import ArcsAndLines
from ..cut.contour_file import read_contour
from .chain import Chain
from .drawn import Drawing, Drawn, Reading, check_size
from .joining import join
from .part import Part, part_of


def read_part(file: Path, reading: Reading | None = None) -> Part:
    """The part of a drawing.

    Raises:
        ValueError: one line with the file's name, what is wrong and where.
        OSError: the file cannot be read.
        ModuleNotFoundError: a package of the extra `parts` is missing.
    """
    reading = reading or Reading()
    try:
        drawing = _drawing(file, reading)
        if not drawing.entities:
            more = f"; {'; '.join(drawing.notes)}" if drawing.notes else ""
            raise ValueError(f"there is nothing to cut{more}")
        check_size(drawing)
        return part_of(join(drawing.entities, reading.join), drawing.notes)
    except ValueError as error:
        said = str(error).removeprefix(f"{file.name}: ")
        raise ValueError(f"{file.name}: {said}") from error


def _drawing(file: Path, reading: Reading) -> Drawing:
    kind = file.suffix.lower()
    if kind == ".dxf":
        from .dxf import read_dxf

        return read_dxf(file, reading)
    if kind == ".svg":
        from .svg import read_svg

        return read_svg(file, reading)
    if kind == ".toml":
        return _from_toml(file, reading)
    raise ValueError("a part is a .dxf, .svg or .toml file")


def _from_toml(file: Path, reading: Reading) -> Drawing:
    if reading.layers:
        raise ValueError("a contour in TOML has no layers")
    curve = read_contour(file)
    assert isinstance(curve, ArcsAndLines)
    return Drawing((Drawn(chain_of(curve), "points", ""),))


def chain_of(curve: ArcsAndLines) -> Chain:
    """Chain of a contour of arcs and lines."""
    lengths, curvature = np.array(curve.elements).T
    ends = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    points = np.vstack([curve.point(ends), curve.point(0.0)])
    return Chain(points, np.tan(lengths * curvature / 4.0))
