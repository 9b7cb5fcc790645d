"""The estimate on the IRB1400 at its poses: 40 mm/s, five updates, all gear effects.

As in `estimation` each seed is another individual, another IMU and its mounting, another assumed
stiffness (each axis wrong by up to 30 %), and other noise. The pass band of the law was chosen at
seeds from 100 on.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path

import numpy as np

from armside.sim.laser.specification import Cut
from armside.sim.robot_file.find import find_cell

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._estimates import case, from_estimate, from_motors, from_tracker

FIVE = 5
LEFT = 0.20
"""Largest fraction of k = 0 that the estimate leaves."""
COLUMNS = {
    **{name: name for name in ("seed", "robot", "pose")},
    "rigid": "error of motor-angle kinematics (3D)",
    "estimate": "error of the estimate (3D)",
    "start": "k = 0",
    "motor": "motor k = 5",
    "learned": "estimate k = 5",
    "tracked": "tracker k = 5",
    "diverged": "any diverged",
}
"""Lengths [um] of one cut, by the tracker but for the first two."""
Place = tuple[int, str, str]
"""Seed, robot or its file, pose."""


def at_poses(robots: Sequence[str], seeds: Sequence[int]) -> Iterator[Place]:
    """Robots at each of their poses."""
    places = [(robot, pose) for robot in robots for pose in find_cell(robot).poses]
    yield from ((seed, *place) for seed, place in product(seeds, places))


def cases(seeds: Sequence[int]) -> Iterator[Place]:
    yield from at_poses(["irb1400"], seeds)


def run(place: Place, tally: Tally) -> Iterator[Row]:
    """One cut learned from estimate, tracker and motors."""
    seed, robot, pose = place
    of = case(Cut(robot=robot, pose=pose), seed)
    learned = from_estimate(of, FIVE, tally)
    tracked = from_tracker(learned, FIVE, tally)
    rigid, estimate = learned.errors()
    yield {
        **{"seed": seed, "robot": Path(robot).stem, "pose": pose},
        **{"rigid": rigid, "estimate": estimate, "start": learned.um[0]},
        "motor": from_motors(of, FIVE, tally).um[-1],
        **{"learned": learned.um[-1], "tracked": tracked.um[-1]},
        "diverged": learned.diverged or tracked.diverged,
    }


def checks(rows: Rows) -> Iterator[Check]:
    left = rows["learned"] / rows["start"]
    words = f"the estimate leaves at most {LEFT:g} of k = 0 (worst {left.max():.3f}"
    median = np.median(left)
    yield Check("", f"{words}, median {median:.3f})", "", left.max(), high=LEFT)
    yield from of_every_arm(rows)


def of_every_arm(rows: Rows) -> Iterator[Check]:
    """Checks of the tool after learning from the estimate, over that after learning from motors."""
    for robot, own in rows.by("robot").items():
        over = own["learned"] / own["motor"]
        words = f"worst {over.max():.2f} of it, median {np.median(over):.2f}"
        yield all_hold(f"{robot}: estimate below motor side in every case ({words})", over < 1.0)
    yield all_hold("no case diverges", ~rows["diverged"])


CLAIM = Claim(
    title="Learning from an estimate of the tool on the IRB1400: tool deviation RMS in µm",
    seeds=10,
    cases=cases,
    run=run,
    checks=checks,
    columns=COLUMNS,
    counted="learned cuts",
)
