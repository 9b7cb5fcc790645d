"""Contours of files: corner points in TOML, or a drawing in DXF.

TOML, in millimetres around the centre of the cut; corners are rounded:

    corner = 1.5
    points = [[-10, -6], [10, -6], [10, 6], [0, 9], [-10, 6]]

A drawing has one closed contour in its units (millimetres if it has none), around its middle: its
place in the drawing does not count. Anything else is refused, as it would not be cut. Where it has
arcs they must join smoothly; corners of lines alone are rounded.
"""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, shown
from armside.kinematics.robot_file import toml_of

from ..motion.contour import ArcsAndLines, Circle, ClosedCurve, chord
from .arcs import MM, Chain, place, wrapped
from .curve import is_circle
from .drawing import JOIN, Reading, Unit, join

SMOOTH = 1e-4
"""Largest angle between elements that join smoothly [rad]."""
SHORTEST = 1e-9
"""Length below which an element is left out [m]."""
CORNER = 1.5
"""Default radius of corners [mm]."""


def rounded(points: ArrayLike, corner: float) -> ArcsAndLines:
    """Polygon through points (K, 2) [m], in either order, with rounded corners [m].

    Raises ValueError for fewer than three points, points that coincide, or a side too short for its
    corners.
    """
    p = np.asarray(points, dtype=np.float64)
    if p.ndim != 2 or p.shape[1] != 2 or len(p) < 3 or not np.isfinite(p).all():
        raise ValueError(f"points must be three or more pairs of numbers, got shape {p.shape}")
    if np.ndim(corner) or not corner > 0.0:
        raise ValueError(f"corner must be > 0 m, got {shown(corner)}")
    following = np.roll(p, -1, axis=0)
    if np.sum(p[:, 0] * following[:, 1] - following[:, 0] * p[:, 1]) < 0.0:  # clockwise
        p = p[::-1]
    side = np.roll(p, -1, axis=0) - p
    length = np.linalg.norm(side, axis=1)
    if length.min() < SHORTEST:
        raise ValueError(f"two points in a row are the same: {place(p[length.argmin()])}")
    heading = np.arctan2(side[:, 1], side[:, 0])
    turn = wrapped(heading - np.roll(heading, 1))  # at the start of each side
    if np.abs(turn).max() > np.pi - 1e-6:
        raise ValueError(f"the contour turns back on itself at {place(p[np.abs(turn).argmax()])}")
    cut = corner * np.tan(np.abs(turn) / 2.0)  # of both sides, for the arc at their corner
    straight = length - cut - np.roll(cut, -1)
    if straight.min() < 0.0:
        worst = int(straight.argmin())
        raise ValueError(
            f"the side from {place(p[worst])} is {length[worst] / MM:.4g} mm long, too short "
            f"for corners of {corner / MM:g} mm"
        )
    bend = np.roll(turn, -1)
    lengths = np.column_stack([straight, corner * np.abs(bend)]).ravel()
    curvature = np.column_stack([np.zeros_like(bend), np.copysign(1.0 / corner, bend)]).ravel()
    first = p[0] + cut[0] * side[0] / length[0]
    return _chain(first, float(heading[0]), lengths, curvature)


def _as_drawn(chain: Chain) -> ArcsAndLines:
    chain = chain if chain.area > 0.0 else chain.reversed
    kinks = np.abs(chain.kinks)
    if (worst := kinks.max()) > SMOOTH:
        raise ValueError(
            f"there is a corner of {np.degrees(worst):.4g} deg at "
            f"{place(chain.points[kinks.argmax()])}; a contour with arcs must be smooth"
        )
    return _chain(chain.points[0], float(chain.heading[0]), chain.lengths, chain.curvature)


def _chain(first: Array, heading: float, lengths: Array, curvature: Array) -> ArcsAndLines:
    """Elements from where they head along +y on their right side, as all contours do."""
    elements = zip(lengths.tolist(), curvature.tolist(), strict=True)
    present = [(length, bend) for length, bend in elements if length > SHORTEST]
    at = first
    best = (-np.inf, 0, 0.0, at)
    for i, (length, bend) in enumerate(present):
        off = float(wrapped(np.pi / 2.0 - heading))
        along = length / 2.0 if abs(off) < 1e-9 else np.inf  # the middle of a line
        if bend != 0.0:
            along = float(np.mod(off * np.sign(bend), 2.0 * np.pi) / abs(bend))
        if along <= length and (there := at + chord(along, bend, heading))[0] > best[0] + SHORTEST:
            best = (float(there[0]), i, along, there)
        at = at + chord(length, bend, heading)
        heading += length * bend
    _, i, along, start = best
    length, bend = present[i]
    turned = [(length - along, bend), *present[i + 1 :], *present[:i], (along, bend)]
    return ArcsAndLines(
        (float(start[0]), float(start[1])), tuple(e for e in turned if e[0] > SHORTEST)
    )


def _from_drawing(file: Path, corner: float) -> ClosedCurve:
    try:
        from .dxf import IMPERIAL, drawing_of, opened
    except ImportError as error:
        raise ImportError("drawings need the package ezdxf: pip install 'armside[dxf]'") from error
    document = opened(file)
    unit = Unit.INCH if document.units in IMPERIAL[:1] else None
    if not document.units:
        unit = Unit.MILLIMETRE
        if document.header.get("$MEASUREMENT", 1) == 0:
            raise ValueError("it is imperial and has no unit; set its unit ($INSUNITS)")
    drawing = drawing_of(document, Reading(unit=unit))
    if left := [note for note in drawing.notes if "paper space" not in note]:
        raise ValueError(f"it has more than its contour: {'; '.join(left)}")
    found, _ = join(drawing.entities, JOIN)
    if len(found) != 1 or not found[0].chain.closed:
        kinds = [f"{'closed' if c.chain.closed else 'open'} {c.name}" for c in found]
        raise ValueError(f"a contour is one closed line, it has {', '.join(kinds) or 'none'}")
    chain = found[0].chain
    if is_circle(chain):
        return Circle(1.0 / abs(float(chain.curvature[0])))
    middle = 0.5 * (chain.points.min(axis=0) + chain.points.max(axis=0))
    chain = Chain(chain.points - middle, chain.bulge)
    return _as_drawn(chain) if chain.bulge.any() else rounded(chain.points[:-1], corner)


def read_contour(file: Path, corner: float | None = None) -> ClosedCurve:
    """Contour of a file.

    corner: radius of its corners [m]; None takes the file's own, or 1.5 mm.

    Raises:
        ValueError: a file that is not as above, or a contour that cannot be cut.
        OSError: the file cannot be read.
        ImportError: a drawing without the package ezdxf.
    """
    kind = file.suffix.lower()
    try:
        if kind == ".toml":
            return _from_toml(file, corner)
        if kind == ".dxf":
            return _from_drawing(file, MM * CORNER if corner is None else corner)
        raise ValueError("a contour is a .toml or a .dxf file")
    except (TypeError, ValueError) as error:
        raise ValueError(f"{file.name}: {error}") from error


def _from_toml(file: Path, corner: float | None) -> ClosedCurve:
    data = toml_of(file.read_bytes())
    if unknown := [name for name in data if name not in ("points", "corner")]:
        raise ValueError(f"{unknown[0]} is not known here. Known: corner, points")
    if "points" not in data:
        raise ValueError("points are missing")
    own = data.get("corner", CORNER)
    if isinstance(own, bool) or not isinstance(own, (int, float)):
        raise ValueError(f"corner must be a number [mm], got {own!r}")
    points = MM * np.array(data["points"], dtype=np.float64)
    return rounded(points, MM * own if corner is None else corner)
