"""DXF drawings at random, with the points of every curve by formulas of the generator's own."""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import ezdxf
import numpy as np
from ezdxf import units
from scipy.interpolate import BSpline

from .drawings import Chances

METRES = {units.MM: 1e-3, units.CM: 1e-2, units.IN: 0.0254, units.M: 1.0}
LAYERS = ("0", "0", "CUT", "CUT", "CUT", "OFF", "COLD")
SAMPLES = 1500


@dataclass
class Generated:
    """A drawing and what is known of it."""

    document: Any
    curves: list[np.ndarray] = field(default_factory=list)
    """(N, 2) [m] of each curve that shows."""
    hidden: int = 0
    """Entities that do not show."""
    refused: set[str] = field(default_factory=set)
    """Types of the entities that show and cannot be cut."""


@dataclass(frozen=True)
class Item:
    """One entity of a block: a curve, an insert, or neither."""

    kind: str
    layer: str
    invisible: bool
    points: np.ndarray | None = None
    block: str = ""
    matrices: tuple[np.ndarray, ...] = ()
    """Of an insert, one for each row and column."""
    frozen: bool = False


def moved(x: float, y: float) -> np.ndarray:
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


class Generator(Chances):
    """A document that grows."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        unit = self.pick(*METRES)
        self.scale = METRES[unit]
        self.size = 1e-3 / self.scale
        """A millimetre in units of the drawing."""
        version = self.pick("R2000", "R2007", "R2010", "R2018")
        document = ezdxf.new(version, units=unit)  # pyright: ignore[reportPrivateImportUsage]
        document.header["$MEASUREMENT"] = int(unit != units.IN)
        self.made = Generated(document)
        for name in ("CUT", "OFF", "COLD"):
            document.layers.add(name)
        document.layers.get("OFF").off()
        document.layers.get("COLD").freeze()
        self.blocks: dict[str, list[Item]] = {}
        self.base: dict[str, np.ndarray] = {}

    def curve(self, space: Any, attributes: dict[str, Any]) -> tuple[str, np.ndarray]:
        """An entity, and its points in units of the drawing."""
        x, y = self.rng.uniform(-40.0, 40.0, 2) * self.size
        r, s = self.rng.uniform(2.0, 12.0, 2) * self.size
        first, span = self.rng.uniform(0.0, 360.0), self.rng.uniform(20.0, 340.0)
        kind = self.pick("LINE", "CIRCLE", "ARC", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE")
        side = 1.0
        if kind in ("CIRCLE", "ARC", "LWPOLYLINE") and self.chance(0.25):
            attributes, side = attributes | {"extrusion": (0, 0, -1)}, -1.0
        t = np.linspace(0.0, 1.0, SAMPLES)[:, None]
        if kind == "LINE":
            space.add_line((x, y), (x + r, y - s), dxfattribs=attributes)
            points = np.array([x, y]) + t * [r, -s]
        elif kind in ("CIRCLE", "ARC"):
            angle = np.radians(first + span * t) if kind == "ARC" else 2.0 * np.pi * t
            if kind == "ARC":
                space.add_arc((x, y), r, first, first + span, dxfattribs=attributes)
            else:
                space.add_circle((x, y), r, dxfattribs=attributes)
            points = np.array([x, y]) + r * np.hstack([np.cos(angle), np.sin(angle)])
        elif kind == "ELLIPSE":
            ratio, (u, v) = self.rng.uniform(0.3, 0.95), (r, s)
            begin, end = (
                (0.0, 2.0 * np.pi) if self.chance(0.5) else np.radians([first, first + span])
            )
            space.add_ellipse((x, y), (u, v), ratio, begin, end, dxfattribs=attributes)
            angle = begin + (end - begin) * t
            major, minor = np.array([u, v]), ratio * np.array([-v, u])
            points = np.array([x, y]) + np.cos(angle) * major + np.sin(angle) * minor
        elif kind == "SPLINE":
            turn = np.sort(self.rng.uniform(0.0, 5.5, 6))
            control = np.column_stack([x + r * np.cos(turn), y + s * np.sin(turn)])
            space.add_open_spline(control.tolist(), degree=3, dxfattribs=attributes)
            knots = [0.0] * 4 + [1.0, 2.0] + [3.0] * 4
            points = BSpline(knots, control, 3)(3.0 * t[:, 0])
        else:
            n = int(self.rng.integers(3, 6))
            turn = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False) + first
            ends = np.column_stack([x + r * np.cos(turn), y + s * np.sin(turn)])
            bulges = np.where(self.rng.random(n) < 0.5, self.rng.uniform(-1.3, 1.3, n), 0.0)
            closed = self.chance(0.7)
            rows = np.column_stack([ends, bulges]).tolist()
            add = space.add_lwpolyline if kind == "LWPOLYLINE" else space.add_polyline2d
            add(rows, format="xyb", close=closed, dxfattribs=attributes)
            points = bulged(np.vstack([ends, ends[:1]]) if closed else ends, bulges)
        return kind, points * [side, 1.0]

    def insert(self, space: Any, attributes: dict[str, Any]) -> tuple[str, tuple[np.ndarray, ...]]:
        name = self.pick(*self.blocks)
        x, y = self.rng.uniform(-30.0, 30.0, 2) * self.size
        turn = self.rng.uniform(0.0, 360.0)
        sx, sy = self.pick((1.0, 1.0), (-1.0, 1.0), (1.6, 0.8), (-0.7, -0.7), (0.9, -1.4))
        own = {"xscale": sx, "yscale": sy, "rotation": turn}
        grid, (rows, columns) = (0.0, 0.0), (1, 1)
        if self.chance(0.2):
            grid, (rows, columns) = self.rng.uniform(20.0, 40.0, 2) * self.size, (2, 3)
            own |= {"row_count": 2, "column_count": 3}
            own |= {"row_spacing": grid[0], "column_spacing": grid[1]}
        flip = np.eye(3)
        if rows == 1 and self.chance(0.15):
            own["extrusion"], flip = (0, 0, -1), np.diag([-1.0, 1.0, 1.0])
        reference = space.add_blockref(name, (x, y), dxfattribs=attributes | own)
        if self.chance(0.05):
            reference.add_attrib("TAG", "8", (x, y))
            self.tagged = True
        c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        stretch = np.diag([sx, sy, 1.0]) @ moved(*-self.base[name])
        return name, tuple(
            flip @ moved(x, y) @ rotation @ moved(grid[1] * i, grid[0] * j) @ stretch
            for j in range(rows)
            for i in range(columns)
        )

    def item(self, space: Any) -> Item:
        layer, invisible = self.pick(*LAYERS), self.chance(0.08)
        attributes = {"layer": layer, "invisible": int(invisible)}
        if self.blocks and self.chance(0.35):
            self.tagged = False
            name, matrices = self.insert(space, attributes)
            kind = "ATTRIB" if self.tagged else "INSERT"
            return Item(kind, layer, invisible, None, name, matrices)
        if self.chance(0.03):
            kind = self.pick("TEXT", "HATCH", "POINT")
            entity = space.new_entity(kind, attributes)
            if kind == "HATCH":
                entity.paths.add_polyline_path([(0, 0), (1, 0), (1, 1)])
            return Item(kind, layer, invisible)
        kind, points = self.curve(space, attributes)
        return Item(kind, layer, invisible, points)

    def show(self, items: list[Item], matrix: np.ndarray, layer: str, gone: bool) -> None:
        """Note what of a block shows where."""
        for item in items:
            own = layer if layer and item.layer == "0" else item.layer
            hidden = gone or item.invisible
            if item.block:
                if item.kind == "ATTRIB" and not hidden and own not in ("OFF", "COLD"):
                    self.made.refused.add("ATTRIB")
                hidden = hidden or own == "COLD"
                for each in item.matrices:
                    self.show(self.blocks[item.block], matrix @ each, own, hidden)
            elif hidden or own in ("OFF", "COLD"):
                self.made.hidden += 1
            elif item.points is None:
                self.made.refused.add(item.kind)
            else:
                points = item.points @ matrix[:2, :2].T + matrix[:2, 2]
                self.made.curves.append(self.scale * points)

    def drawing(self) -> Generated:
        """The drawing of a seed."""
        for i in range(self.rng.integers(1, 4)):
            base = self.rng.uniform(-10.0, 10.0, 2) * self.size
            block = self.made.document.blocks.new(f"B{i}", base_point=tuple(base))
            items = [self.item(block) for _ in range(self.rng.integers(1, 4))]
            self.blocks[f"B{i}"], self.base[f"B{i}"] = items, base
        space = self.made.document.modelspace()
        items = [self.item(space) for _ in range(self.rng.integers(3, 9))]
        self.show(items, np.eye(3), "", False)
        return self.made


def bulged(ends: np.ndarray, bulges: np.ndarray) -> np.ndarray:
    """Points of lines and arcs from end to end."""
    found = []
    for (p, q), bulge in zip(pairwise(ends), bulges, strict=False):
        t = np.linspace(0.0, 1.0, SAMPLES)[:, None]
        if bulge == 0.0:
            found.append(p + t * (q - p))
            continue
        # A Moebius map takes the chord to the circle through its ends; above 0 bulges to the right.
        turn = 0.5 + 0.5 * np.tan(np.arctan(bulge) * (2.0 * t[:, 0] - 1.0)) / bulge
        one, other = (1.0 - turn) * (1.0 + 1j * bulge), turn * (1.0 - 1j * bulge)
        z = (complex(*p) * one + complex(*q) * other) / (one + other)
        found.append(np.column_stack([z.real, z.imag]))
    return np.vstack(found)


def generated(seed: int) -> Generated:
    """The drawing of a seed."""
    return Generator(seed).drawing()
