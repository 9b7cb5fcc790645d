"""Drawings that the tests write."""

import ezdxf
import numpy as np
from ezdxf import units

QUARTER = np.tan(np.pi / 8)
"""Bulge of a quarter of a turn."""


def new(version="R2010", unit=units.MM):
    return ezdxf.new(version, units=unit)  # pyright: ignore[reportPrivateImportUsage]


def save(document, folder, name="part.dxf"):
    document.saveas(folder / name)
    return folder / name


def frame(space, width=100.0, height=60.0, x=-10.0, y=-10.0, **attributes):
    """A rectangle of four lines, lower left corner at (x, y)."""
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
        space.add_line(start, end, dxfattribs=attributes)


def bracket(document):
    """300 x 200 mm: outline of lines and arcs, eight holes, a slot, a spline cut-out, a text."""
    space, (w, h, r) = document.modelspace(), (300.0, 200.0, 15.0)
    cut = {"layer": "CUT"}
    for layer in ("CUT", "NOTES"):
        document.layers.add(layer)
    for a, b in [
        ((r, 0), (w - r, 0)),
        ((w, r), (w, h - r)),
        ((w - r, h), (r, h)),
        ((0, h - r), (0, r)),
    ]:
        space.add_line(a, b, dxfattribs=cut)
    for x, y, first in [(w - r, r, 270), (w - r, h - r, 0), (r, h - r, 90), (r, r, 180)]:
        space.add_arc((x, y), r, first, first + 90, dxfattribs=cut)
    for x in (30.0, 110.0, 190.0, 270.0):
        for y in (30.0, 170.0):
            space.add_circle((x, y), 5.0, dxfattribs=cut)
    slot = [(60, 90, 0, 0, 0), (100, 90, 0, 0, 1), (100, 102, 0, 0, 0), (60, 102, 0, 0, 1)]
    space.add_lwpolyline(slot, close=True, dxfattribs=cut)
    angle = np.linspace(0.0, 2.0 * np.pi, 9)
    radius = np.where(np.arange(9) % 2, 18.0, 28.0)
    points = np.column_stack([200 + radius * np.cos(angle), 100 + radius * np.sin(angle)])
    space.add_cad_spline_control_frame(points.tolist(), tangents=[(0, 1), (0, 1)]).dxf.layer = "CUT"
    space.add_text("M10 x 8", dxfattribs={"layer": "NOTES"}).set_placement((120, 60))
    return document


def flange(document, holes=24):
    """A ring of 24 holes around a bore."""
    space = document.modelspace()
    for radius in (100.0, 40.0):
        space.add_circle((0, 0), radius)
    for angle in np.linspace(0.0, 2.0 * np.pi, holes, endpoint=False):
        space.add_circle((80 * np.cos(angle), 80 * np.sin(angle)), 4.0)
    return document


class Chances:
    """Decisions of a generator of drawings."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def chance(self, p: float) -> bool:
        return bool(self.rng.random() < p)

    def pick(self, *options):
        return options[self.rng.integers(len(options))]
