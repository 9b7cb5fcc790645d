"""A part read from a drawing: its outline, holes and open cuts, told apart and checked."""

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from armside.arrays import Array

from ..motion.contour import ArcsAndLines
from .arcs import MM, Chain, place
from .contour_file import read_contour
from .curve import Kind
from .drawing import Drawing, DrawnChain, Reading, check_size, join, shapely

SAGITTA = 2e-6
"""Of the polygons that contours are compared by [m]."""
Made = TypeVar("Made")
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


def part_of(chains: list[DrawnChain], notes: tuple[str, ...] = ()) -> Part:
    """Contours told apart by what contains them; the largest is the outline."""
    if not chains:
        raise ValueError("there is nothing to cut")
    around = [i for i, each in enumerate(chains) if each.chain.closed]
    if not around:
        first, last = chains[0].chain.points[[0, -1]]
        ends = (
            f"{np.linalg.norm(last - first) / MM:.4g} mm apart at {place(first)} and {place(last)}"
        )
        raise ValueError(f"no contour is closed; {chains[0].name} ends {ends}")
    lines = [shapely.LineString(c.chain.polygon(SAGITTA)) for c in chains]
    for chain, drawn in zip(chains, lines, strict=True):
        if not shapely.is_simple(drawn):
            raise ValueError(f"{chain.name} crosses itself{_crossing(drawn, chain.chain.closed)}")
    _check_apart(chains, lines)
    areas = [shapely.Polygon(lines[i]) for i in around]
    # Number of closed contours around each.
    inside, container = shapely.STRtree(areas).query(lines, predicate="within")
    others = inside[np.array(around)[container] != inside]
    depth = np.bincount(others, minlength=len(lines)).tolist()
    outer = around[int(np.argmax([area.area for area in areas]))]
    contours, seen = list[PartContour](), Counter[str]()
    for i, (chain, level) in enumerate(zip(chains, depth, strict=True)):
        if i != outer and level == 0:
            at = place(chain.chain.point(0.0))
            raise ValueError(
                f"{chain.name} at {at} lies outside the outline, {chains[outer].name}; "
                "a drawing has one part"
            )
        kind, drawn = Kind.OPEN, chain.chain
        if drawn.closed:
            kind = Kind.HOLE if level % 2 else Kind.OUTLINE
            drawn = drawn if drawn.area > 0.0 else drawn.reversed
        seen[chain.name] += 1  # names repeat, such as those of the entities of one block
        n = seen[chain.name]
        name = chain.name if n == 1 else f"{chain.name} ({n})"
        contours.append(
            PartContour(kind=kind, chain=drawn, name=name, layer=chain.layer, depth=level)
        )
    return Part(tuple(contours), notes)


def _crossing(drawn: Any, closed: bool) -> str:
    """Place where a line meets itself: a node of its own noding that it passes twice."""
    reason = str(shapely.is_valid_reason(shapely.Polygon(drawn))) if closed else ""
    if found := re.search(r"\[(\S+) (\S+)\]$", reason):
        return f" at {place([float(value) for value in found.groups()])}"
    ends = {tuple(drawn.coords[0]), tuple(drawn.coords[-1])}
    nodes = (part.coords[-1] for part in list(shapely.node(drawn).geoms)[:-1])
    return next((f" at {place(node)}" for node in nodes if tuple(node) not in ends), "")


def _check_apart(chains: list[DrawnChain], lines: list[Any]) -> None:
    pairs = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=TWICE).T
    for i, j in pairs[pairs[:, 0] < pairs[:, 1]]:
        both, common = f"{chains[i].name} and {chains[j].name}", lines[i].intersection(lines[j])
        if common.is_empty:
            between = shapely.shortest_line(lines[i], lines[j])
            at = place(shapely.get_coordinates(between)[0])
            apart = f"{shapely.length(between) / MM:.2g} mm apart at {at}"
            raise ValueError(f"{both} are {apart}: drawn twice?")
        at = place(shapely.get_coordinates(common)[0])
        how = "lie on each other" if common.length > 10 * SAGITTA else "cross or touch"
        raise ValueError(f"{both} {how} at {at}")


def read_part(file: Path, reading: Reading | None = None) -> Part:
    """The part of a drawing.

    Raises:
        ValueError: one line with the file's name, what is wrong and where.
        OSError: the file cannot be read.
        ModuleNotFoundError: a package of the extra `parts` is missing.
    """
    return read_chains(file, reading or Reading(), part_of)


def read_chains(
    file: Path, reading: Reading, made: Callable[[list[DrawnChain], tuple[str, ...]], Made]
) -> Made:
    """What is made of the joined chains of a drawing and its notes. Raises as `read_part` does."""
    try:
        drawing = _drawing(file, reading)
        if not drawing.entities:
            more = f"; {'; '.join(drawing.notes)}" if drawing.notes else ""
            raise ValueError(f"there is nothing to cut{more}")
        check_size(drawing)
        chains, gaps = join(drawing.entities, reading.join)
        return made(chains, (*drawing.notes, *gaps))
    except ValueError as error:
        reason = str(error).removeprefix(f"{file.name}: ")
        raise ValueError(f"{file.name}: {reason}") from error


def _drawing(file: Path, reading: Reading) -> Drawing:
    match file.suffix.lower():
        case ".dxf":
            from .dxf import read_dxf

            return read_dxf(file, reading)
        case ".svg":
            from .svg import read_svg

            return read_svg(file, reading)
        case ".toml":
            if reading.layers:
                raise ValueError("a contour in TOML has no layers")
            curve = read_contour(file)
            assert isinstance(curve, ArcsAndLines)
            lengths, curvature = np.array(curve.elements).T
            ends = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
            points = np.vstack([curve.point(ends), curve.point(0.0)])
            chain = Chain(points, np.tan(lengths * curvature / 4.0))
            return Drawing((DrawnChain(chain, "points", ""),))
    raise ValueError("a part is a .dxf, .svg or .toml file")
