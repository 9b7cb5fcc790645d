"""Contour files: corner points in TOML, or a drawing (`drawing`).

TOML, in millimetres around the centre of the cut; corners are rounded:

    corner = 1.5
    points = [[-10, -6], [10, -6], [10, 6], [0, 9], [-10, 6]]
"""

import tomllib
from pathlib import Path

import numpy as np

from .contour import ClosedCurve
from .drawing import read_drawing
from .polyline import MM, rounded

CORNER = 1.5
"""Default radius of corners [mm]."""


def read_contour(file: Path, corner: float | None = None) -> ClosedCurve:
    """Contour of a file.

    corner: radius of its corners [m]; None takes the file's own, or 1.5 mm.

    Raises:
        ValueError: a file that is not as above, or a contour that cannot be cut.
        OSError: the file cannot be read.
        ImportError: a drawing without the package ezdxf.
    """
    kind = file.suffix.lower()
    if kind == ".toml":
        return _from_toml(file, corner)
    if kind == ".dxf":
        return read_drawing(file, MM * CORNER if corner is None else corner)
    raise ValueError(f"{file.name}: a contour is a .toml or a .dxf file")


def _from_toml(file: Path, corner: float | None) -> ClosedCurve:
    try:
        data = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{file.name}: {error}") from error
    if unknown := [name for name in data if name not in ("points", "corner")]:
        raise ValueError(f"{file.name}: {unknown[0]} is not known here. Known: corner, points")
    if "points" not in data:
        raise ValueError(f"{file.name}: points are missing")
    own = data.get("corner", CORNER)
    if isinstance(own, bool) or not isinstance(own, (int, float)):
        raise ValueError(f"{file.name}: corner must be a number [mm], got {own!r}")
    try:
        points = MM * np.array(data["points"], dtype=np.float64)
        return rounded(points, MM * own if corner is None else corner)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{file.name}: {error}") from error
