"""Time to plan a whole part of many contours."""

from collections.abc import Sequence

import numpy as np

from armside.sim.laser.part_cut import PartCut
from armside.sim.part.arcs import MM, Chain, arc, joined, line
from armside.sim.part.drawing import Joined
from armside.sim.part.part import Part, part_of
from armside.sim.part.plan import Cutting

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
    return timed({name: lambda: cut.plan}, repeats=1)


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
    return part_of([Joined(chain, (name,), "") for name, chain in named])


def _slot(at: np.ndarray, half: float, radius: float) -> Chain:
    """Two lines and two half circles; half: of the lines' length [m]."""
    x, y = at
    ends = [(x + half, -np.pi / 2.0), (x - half, np.pi / 2.0)]
    right, left = (arc((c, y), radius, begin, np.pi) for c, begin in ends)
    lower, upper = line(left.points[-1], right.points[0]), line(right.points[-1], left.points[0])
    found = joined([lower, right, upper, left])
    return Chain(np.vstack([found.points[:-1], found.points[:1]]), found.bulge)
