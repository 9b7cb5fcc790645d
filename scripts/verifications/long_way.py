"""The claims of `armside verify long-way`: learning from the estimate along long contours.

All effects of the gears are on. Each seed is another individual, another IMU screwed on differently
with its clock off by up to 10 ms, another assumed stiffness (each axis wrong by up to 30 %), and
other noise. Settings were chosen on `DEVELOPMENT`; the seeds that judge count up from 0.
"""

from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np

from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.notes import Tally
from armside.sim.records.run_folder import RUNS

from ..jobs.store import Store, run_batch
from ..jobs.workers import Workers
from .long_way_cut import TASKS, Found, WayJob, found_of

DEVELOPMENT = {100: ("p1", "p2", "p3"), 101: ("p2", "p3")}
"""Seeds and poses on which settings were chosen. Those that judge are below 100."""
POSES = ("p1", "p2", "p3")
KEPT = RUNS / "verify-long-way"
"""Folder of the cuts that are finished: a command that was stopped goes on from there."""
WORST, MEDIAN, TRACKER, NEES = 0.25, 0.15, 0.10, 10.0
COLUMNS = ("seed", "pose", "contour", "k = 0", "estimate k = 5", "tracker k = 5", "NEES")


def long_way(seeds: Sequence[int], kept: Path = KEPT) -> Table:
    """All tasks at p1, p2, p3; five updates from the estimate and from the tracker.

    kept: folder in which each cut is stored as it ends, and found by the next call.
    """
    jobs = [WayJob(seed=s, pose=p, task=t) for s, p, t in product(seeds, POSES, TASKS)]
    store = Store(kept)
    with Workers() as workers:
        run_batch([job for job in jobs if not store.holds(job)], store, workers=workers)
    return table([found_of(job, store.load(job)) for job in jobs])


def table(found: Sequence[Found]) -> Table:
    """A row for each cut, and the verdicts over all."""
    said = Tally()
    for one in found:
        said.add(one.notes)
    return Table(
        "Learning from an estimate along long contours: tool deviation RMS in µm",
        COLUMNS,
        [
            (f.seed, f.pose, f.task, *(1e6 * x for x in (f.start, f.estimate, f.tracker)), f.nees)
            for f in found
        ],
        verdicts(found),
        said.notes("learned cuts"),
    )


def verdicts(found: Sequence[Found]) -> list[Check]:
    """Over all cuts together."""
    left = np.array([f.estimate / f.start for f in found])
    tracker = np.array([f.tracker / f.start for f in found])
    consistent = [
        float(np.mean([f.nees for f in found if f.task == task]))
        for task in dict.fromkeys(f.task for f in found)
    ]
    above, silent = int((left > 1.0).sum()), sum(f.silent for f in found)
    n = len(found)
    return [
        _bounded("estimate after five updates over k = 0: worst", left.max(), WORST),
        _bounded("the same: median", float(np.median(left)), MEDIAN),
        _bounded("tracker after five updates over k = 0: worst", tracker.max(), TRACKER),
        _bounded("NEES of the tool, mean of the worst contour", max(consistent), NEES),
        all_hold(f"the estimate never ends above k = 0 ({above} of {n} do)", left <= 1.0),
        all_hold(
            f"never done while the truth has grown ({silent} of {n} are)",
            [not f.silent for f in found],
        ),
    ]


def _bounded(statement: str, value: float, bar: float) -> Check:
    return Check("", f"{statement}: at most {bar:g} ({value:.3f})", "", value, high=bar)
