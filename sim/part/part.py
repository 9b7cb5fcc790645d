"""A part read from a drawing: its outline, holes and open cuts, told apart and checked."""

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..motion.contour import ArcsAndLines
from .arcs import MM, Chain, place
from .contour_file import read_contour
from .curve import Kind
from .drawing import Drawing, DrawnEntity, Joined, Reading, check_size, join
from .geometry import shapely

SAGITTA = 2e-6
"""Of the polygons that contours are compared by [m]."""
TWICE = 5e-6
"""Distance up to which two contours are taken for one that is drawn twice [m]."""


@dataclass(frozen=True, kw_only=True)
class PartContour:
    """One contour of a part, counter-clockwise if closed."""

    kind: Kind
    chain: Chain = field(repr=False)
    name: str
    """Its entities."""
    layer: str
    depth: int
    """Number of contours around it."""


@dataclass(frozen=True)
class Part:
    """Contours in the coordinates of the drawing."""

    contours: tuple[PartContour, ...]
    notes: tuple[str, ...] = ()

    @cached_property
    def box(self) -> Array:
        """(2, 2) [m], lower left and upper right corner."""
        points = np.vstack([contour.chain.polygon() for contour in self.contours])
        return np.array([points.min(axis=0), points.max(axis=0)])

    @property
    def middle(self) -> Array:
        """(2,) [m], of the box around it."""
        return self.box.mean(axis=0)


def part_of(chains: list[Joined], notes: tuple[str, ...] = ()) -> Part:
    """Contours told apart by what contains them; the largest is the outline.

    Raises ValueError for chains that cross themselves or each other, or lie outside the outline.
    """
    if not chains:
        raise ValueError("there is nothing to cut")
    closed = [c for c in chains if c.chain.closed]
    if not closed:
        raise ValueError(f"no contour is closed; {_open_at(chains[0])}")
    lines = [shapely.LineString(c.chain.polygon(SAGITTA)) for c in chains]
    for chain, drawn in zip(chains, lines, strict=True):
        _check_simple(chain, drawn)
    _check_apart(chains, lines)
    areas = [
        shapely.Polygon(drawn) if chain.chain.closed else None
        for chain, drawn in zip(chains, lines, strict=True)
    ]
    depth = _depths(lines, areas)
    outer = int(np.argmax([0.0 if area is None else area.area for area in areas]))
    for i, (chain, level) in enumerate(zip(chains, depth, strict=True)):
        if i != outer and level == 0:
            at = place(chain.chain.point(0.0))
            raise ValueError(
                f"{chain.name} at {at} lies outside the outline, {chains[outer].name}; "
                "a drawing has one part"
            )
    named = zip(chains, _different([chain.name for chain in chains]), depth, strict=True)
    return Part(tuple(_contour(*each) for each in named), notes)


def _different(names: list[str]) -> list[str]:
    """Names with a number where they repeat, such as those of the entities of one block."""
    seen, found = Counter[str](), list[str]()
    for name in names:
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return found


def _contour(chain: Joined, name: str, depth: int) -> PartContour:
    kind, drawn = Kind.OPEN, chain.chain
    if drawn.closed:
        kind = Kind.HOLE if depth % 2 else Kind.OUTLINE
        drawn = drawn if drawn.area > 0.0 else drawn.reversed
    return PartContour(kind=kind, chain=drawn, name=name, layer=chain.layer, depth=depth)


def _check_simple(chain: Joined, drawn: Any) -> None:
    if shapely.is_simple(drawn):
        return
    reason = str(shapely.is_valid_reason(shapely.Polygon(drawn))) if chain.chain.closed else ""
    at = reason[reason.find("[") + 1 : -1].split() if "[" in reason else []
    where = f" at {place([float(v) for v in at])}" if len(at) == 2 else _own_crossing(drawn)
    raise ValueError(f"{chain.name} crosses itself{where}")


def _own_crossing(drawn: Any) -> str:
    """Place where an open line meets itself: a node of its own noding that it passes twice."""
    parts = list(shapely.node(drawn).geoms)
    inner = {tuple(drawn.coords[0]), tuple(drawn.coords[-1])}
    for one, _ in pairwise(parts):
        if tuple(one.coords[-1]) not in inner:
            return f" at {place(one.coords[-1])}"
    return ""


def _check_apart(chains: list[Joined], lines: list[Any]) -> None:
    tree = shapely.STRtree(lines)
    pairs = tree.query(lines, predicate="dwithin", distance=TWICE).T
    for i, j in pairs[pairs[:, 0] < pairs[:, 1]]:
        common = lines[i].intersection(lines[j])
        if common.is_empty:
            between = shapely.shortest_line(lines[i], lines[j])
            at = place(shapely.get_coordinates(between)[0])
            apart = f"{shapely.length(between) / MM:.2g} mm apart at {at}"
            raise ValueError(f"{chains[i].name} and {chains[j].name} are {apart}: drawn twice?")
        at = place(shapely.get_coordinates(common)[0])
        how = "lie on each other" if common.length > 10 * SAGITTA else "cross or touch"
        raise ValueError(f"{chains[i].name} and {chains[j].name} {how} at {at}")


def _depths(lines: list[Any], areas: list[Any]) -> list[int]:
    """Number of closed contours around each."""
    around = [i for i, area in enumerate(areas) if area is not None]
    tree = shapely.STRtree([areas[i] for i in around])
    inside, container = tree.query(lines, predicate="within")
    counted = np.array(around)[container] != inside
    return np.bincount(inside[counted], minlength=len(lines)).tolist()


def _open_at(chain: Joined) -> str:
    first, last = chain.chain.points[[0, -1]]
    gap = np.linalg.norm(last - first) / MM
    return f"{chain.name} ends {gap:.4g} mm apart at {place(first)} and {place(last)}"


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
        chains, gaps = join(drawing.entities, reading.join)
        return part_of(chains, (*drawing.notes, *gaps))
    except ValueError as error:
        reason = str(error).removeprefix(f"{file.name}: ")
        raise ValueError(f"{file.name}: {reason}") from error


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
    return Drawing((DrawnEntity(chain_of(curve), "points", ""),))


def chain_of(curve: ArcsAndLines) -> Chain:
    """Chain of a contour of arcs and lines."""
    lengths, curvature = np.array(curve.elements).T
    ends = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    points = np.vstack([curve.point(ends), curve.point(0.0)])
    return Chain(points, np.tan(lengths * curvature / 4.0))
