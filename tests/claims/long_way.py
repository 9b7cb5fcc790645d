"""Learning from the estimate along long contours, at p1, p2, p3; five updates.

All effects of the gears are on. Each seed is another individual, another IMU screwed on differently
with its clock off by up to 10 ms, another assumed stiffness (each axis wrong by up to 30 %), and
other noise. Settings were chosen on `DEVELOPMENT`; the seeds that judge count up from 0.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from armside.sim.laser.results import GROWTH, status
from armside.sim.laser.specification import Cut
from armside.sim.motion.contour import Circle, ClosedCurve
from armside.sim.part.contour_file import rounded

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_most, crossed
from ._estimates import case, from_estimate, nees, tracked_along
from ._learned import POSES

DEVELOPMENT = {100: ("p1", "p2", "p3"), 101: ("p2", "p3")}
"""Seeds and poses on which settings were chosen. Those that judge are below 100."""
UPDATES = 5
WORST, MEDIAN, TRACKER, NEES = 0.25, 0.15, 0.10, 10.0
_OUTLINE = 0.5 * np.array([[-0.3, -0.08], [0.3, -0.08], [0.3, 0.08], [-0.3, 0.08]])
OUTLINE: ClosedCurve = rounded(_OUTLINE, 0.005)
"""300 x 80 mm with corners of 5 mm."""
TASKS: Mapping[str, Cut] = {
    "radius 20 mm, 80 mm/s": Cut(contour=Circle(0.020), speed=0.08),
    "radius 50 mm, 80 mm/s": Cut(contour=Circle(0.050), speed=0.08),
    "radius 100 mm, 80 mm/s": Cut(contour=Circle(0.100), speed=0.08),
    "300 x 80 mm, 40 mm/s": Cut(contour=OUTLINE, speed=0.04),
    "300 x 80 mm, 80 mm/s": Cut(contour=OUTLINE, speed=0.08),
}
"""Cuts by name, at p1."""


def run(place: tuple[int, str, str], tally: Tally) -> Iterator[Row]:
    seed, pose, task = place
    learned = from_estimate(case(replace(TASKS[task], pose=pose), seed), UPDATES, tally)
    tracked = tracked_along(learned, UPDATES)
    first, last = (learned.iterations[k].tool_true.rms for k in (0, -1))
    done = status(learned.iterations, of_tool=True) == "done"
    yield {
        **{"seed": seed, "pose": pose, "contour": task},
        "k = 0": learned.um[0],
        "estimate k = 5": learned.um[-1],
        "tracker k = 5": tracked.um[-1],
        "NEES": nees(learned),
        "_silent": last > GROWTH * first and done,
    }


def checks(rows: Rows) -> Iterator[Check]:
    left, tracker = (rows[f"{by} k = 5"] / rows["k = 0"] for by in ("estimate", "tracker"))
    consistent = [own["NEES"].mean() for own in rows.by("contour").values()]
    silent, n = rows["_silent"], len(rows)
    yield at_most("estimate after five updates over k = 0: worst", left.max(), WORST)
    yield at_most("the same: median", float(np.median(left)), MEDIAN)
    yield at_most("tracker after five updates over k = 0: worst", tracker.max(), TRACKER)
    yield at_most("NEES of the tool, mean of the worst contour", max(consistent), NEES)
    above = int((left > 1.0).sum())
    yield all_hold(f"the estimate never ends above k = 0 ({above} of {n} do)", left <= 1.0)
    grown = f"never done while the truth has grown ({silent.sum()} of {n} are)"
    yield all_hold(grown, ~silent)


CLAIM = Claim(
    title="Learning from an estimate along long contours: tool deviation RMS in µm",
    seeds=10,
    cases=crossed(POSES, TASKS),
    run=run,
    checks=checks,
    counted="learned cuts",
)
