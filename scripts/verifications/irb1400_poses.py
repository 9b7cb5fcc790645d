"""Claims about motor-side learning on the IRB1400 at random poses and speeds.

Each seed is another pose, speed and individual, and other noise. The design is that of the robot,
chosen at p1; other gains, shifts and cutoffs, gains by the first update, momentum over iterations
and inverses of models did no better at seeds from 100 on.
"""

from collections.abc import Iterable

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures
from armside.sim.evaluation.check import Table, all_hold
from armside.sim.laser.random_cuts import random_cut
from armside.sim.laser.specification import Cut
from armside.sim.notes import Tally

from .learned import learned

ROBOT = "irb1400"
LEARNED = 0.10


def poses(seeds: Iterable[int]) -> Table:
    """Motors and tool after five updates."""
    said = Tally()
    rows = [_row(random_cut(ROBOT, seed), seed, said) for seed in seeds]
    worst = np.array([row[3] for row in rows])
    words = f"every motor's inf-norm ends at {LEARNED:g} or below, normalised as (9.5)"
    over = f"{(worst > LEARNED).sum()} of {len(worst)} do not, median {np.median(worst):.3f}"
    fewer = "every motor's inf-norm falls below that of the worst motor at k = 0"
    return Table(
        "Motor-side learning on the IRB1400 at random poses and speeds of 12 to 77 mm/s",
        (
            *("seed", "speed [mm/s]", "worst inf-norm, k = 1", "k = 5", "its motor"),
            *("arm, k = 0 [um]", "k = 5"),
        ),
        rows,
        [
            all_hold(f"{words}; {over}, worst {worst.max():.3f}", worst <= LEARNED),
            all_hold(fewer, worst < 1.0),
        ],
        said.notes("runs"),
    )


def _row(cut: Cut, seed: int, said: Tally) -> tuple[float, ...]:
    run = learned(cut, seed)
    said.add(run.notes)
    first, last = (_normalised(run["motor_inf"], k) for k in (1, -1))
    arm = (1e6 * float(run["arm_rms"][k]) for k in (0, -1))
    worst = float(last.max()), int(1 + last.argmax())
    return seed, 1e3 * cut.speed, float(first.max()), *worst, *arm


def _normalised(norm: Array, k: int) -> Array:
    """(6,) after k updates, over the largest of all motors at k = 0. Thesis (9.5)."""
    return measures.normalise(norm[k], norm[0])
