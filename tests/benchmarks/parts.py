"""Time to plan a whole part of many contours."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from armside.sim.laser.part_cut import PartCut
from armside.sim.part.arcs import MM, Chain, arc, joined, line
from armside.sim.part.drawing import DrawnChain
from armside.sim.part.part import Part, part_of, read_part
from armside.sim.part.plan import Cutting, plan

from ._timing import Row, timed

ENTITIES = 500
"""An outline of four lines, and slots of four entities and circles in turns."""
PITCH = 12 * MM
COLUMNS = 20
SPEED, POSE = 0.100, "p1"
"""[m/s], and place at which the joints limit most contours."""


def measured() -> Sequence[Row]:
    """A part of 500 entities, within the limits of joints and drives."""
    part = sheet(ENTITIES)
    cut = PartCut(part=part, cutting=Cutting(speed=SPEED), pose=POSE)
    name = f"plan of {ENTITIES} entities, {len(part.contours)} contours, at {POSE}"
    drawing, n = svg(ENTITIES), f"{ENTITIES} contours of an SVG drawing"
    with TemporaryDirectory() as folder:
        file = Path(folder) / "sheet.svg"
        file.write_text(drawing)
        cases = {
            name: lambda: replace(cut).plan,  # a plan is kept by its cut
            f"{n} read": lambda: read_part(file),
            f"{n} read and planned": lambda: plan(read_part(file)),
        }
        return timed(cases, repeats=1)


def svg(contours: int) -> str:
    """A sheet with round holes of as many sizes, and its outline."""
    holes = "".join(
        f'<circle cx="{20 * (i % 23) + 15}" cy="{20 * (i // 23) + 15}" r="{3 + 0.01 * i}"/>'
        for i in range(contours - 1)
    )
    size = 'width="480mm" height="480mm" viewBox="0 0 480 480"'
    paint = 'fill="none" stroke="red"'
    outline = '<rect width="480" height="480"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} {paint}>{outline}{holes}</svg>'


def sheet(entities: int, seed: int = 0) -> Part:
    """A sheet with slots and round holes of random sizes in rows, of that many entities."""
    rng, chains, left = np.random.default_rng(seed), list[Chain](), entities - 4
    while left > 0:
        row, column = divmod(len(chains), COLUMNS)
        at = PITCH * (np.array([column, row]) + 1.0)
        if left >= 4 and len(chains) % 3 == 0:
            chains.append(_slot(at, rng.uniform(2.0, 3.5) * MM, rng.uniform(1.0, 2.0) * MM))
            left -= 4
        else:
            chains.append(arc(at, rng.uniform(1.5, 4.0) * MM, 0.0, 2.0 * np.pi))
            left -= 1
    w, h = PITCH * (COLUMNS + 1), PITCH * ((len(chains) - 1) // COLUMNS + 2)
    outline = line((0.0, 0.0), (w, 0.0), (w, h), (0.0, h), (0.0, 0.0))
    named = [("outline", outline), *((f"hole {i}", one) for i, one in enumerate(chains))]
    return part_of([DrawnChain(chain, name, "") for name, chain in named])


def _slot(at: np.ndarray, half: float, radius: float) -> Chain:
    """Two lines and two half circles; half: of the lines' length [m]."""
    x, y = at
    ends = [(x + half, -np.pi / 2.0), (x - half, np.pi / 2.0)]
    right, left = (arc((c, y), radius, begin, np.pi) for c, begin in ends)
    lower, upper = line(left.points[-1], right.points[0]), line(right.points[-1], left.points[0])
    found = joined([lower, right, upper, left])
    return Chain(np.vstack([found.points[:-1], found.points[:1]]), found.bulge)
