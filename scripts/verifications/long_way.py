"""The claims of `armside verify long-way`: learning from the estimate along long contours.

All effects of the gears are on. Each seed is another individual, another IMU screwed on differently
with its clock off by up to 10 ms, another assumed stiffness (each axis wrong by up to 30 %), and
other noise. Settings were chosen on `DEVELOPMENT`; the seeds that judge count up from 0.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import normalised_squared
from armside.sim.cut.contour import Circle, ClosedCurve
from armside.sim.cut.polyline import rounded
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.estimation.tool_law import ToolLaw
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import Case, rms
from armside.sim.laser.experiment import Iteration
from armside.sim.laser.learning import first_run, learned
from armside.sim.laser.notes import GROWTH, notes
from armside.sim.laser.plant import Pass
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import Source
from armside.sim.laser.way_measure import PathAlongWay, WayOutput
from armside.sim.notes import Cause, Tally

from ..jobs.workers import Workers

DEVELOPMENT = {100: ("p1", "p2", "p3"), 101: ("p2", "p3")}
"""Seeds and poses on which settings were chosen. Those that judge are below 100."""
POSES = ("p1", "p2", "p3")
UPDATES = 5
MEASURE = PathAlongWay(law=ToolLaw(gamma=0.8))
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
WORST, MEDIAN, TRACKER, NEES = 0.25, 0.15, 0.10, 10.0


@dataclass(frozen=True, kw_only=True)
class Found:
    """One cut of one seed. Lengths in m, by the tracker unless true."""

    seed: int
    pose: str
    task: str
    start: float
    estimate: float
    tracker: float
    nees: float
    """Mean over the first run, of the tool's position: 3 for an estimator that knows its error."""
    silent: bool
    """The truth has grown, and the run ends as done without saying so."""
    said: Tally


def long_way(seeds: Iterable[int]) -> Table:
    """All tasks at p1, p2, p3; five updates from the estimate and from the tracker."""
    with Workers() as workers:
        found = workers.map(tried, list(product(seeds, POSES, TASKS)))
    said = Tally()
    for one in found:
        said.include(one.said)
    return Table(
        "Learning from an estimate along long contours: tool deviation RMS in µm",
        ("seed", "pose", "contour", "k = 0", "estimate k = 5", "tracker k = 5", "NEES"),
        [
            (f.seed, f.pose, f.task, *(1e6 * x for x in (f.start, f.estimate, f.tracker)), f.nees)
            for f in found
        ],
        verdicts(found),
        said.notes("learned cuts"),
    )


def tried(case: tuple[int, str, str]) -> Found:
    """One cut: commissioned once, learned from the estimate and from the tracker."""
    seed, pose, task = case
    known = Case(cut=replace(TASKS[task], pose=pose, imu=ImuCfg()), seed=seed)
    output, learning = known.from_tool(UPDATES, MEASURE)
    assert isinstance(output, WayOutput)
    iterations, experiment = list(learning), known.experiment()
    by_tracker = replace(output, measure=replace(output.measure, source=Source.TRACKER))
    tracked = list(learned(experiment, by_tracker, first_run(experiment), UPDATES))
    all_notes = notes(experiment, iterations)
    said = Tally()
    said.add(all_notes)
    return Found(
        seed=seed,
        pose=pose,
        task=task,
        start=rms(iterations)[0],
        estimate=rms(iterations)[-1],
        tracker=rms(tracked)[-1],
        nees=nees(output, iterations[0].run),
        silent=_grown(iterations) and not any(note.cause is Cause.TOOL for note in all_notes),
        said=said,
    )


def _grown(iterations: Sequence[Iteration]) -> bool:
    first, last = iterations[0], iterations[-1]
    return not last.diverged and last.tool_true.rms > GROWTH * first.tool_true.rms


def nees(output: WayOutput, run: Pass) -> float:
    """Mean normalised squared error of the estimated position while the arm moves."""
    log, truth = run.recording, run.recording.truth
    every = round(float(log.time[1] / truth.time[1]))
    error: Array = (output(run) - relative_to_start(truth.tool_position[::every]))[:, :3]
    moving = slice(int(np.argmax(log.time > 0.4)), None)
    P = output.way.tool_covariance(output.experiment.nominal)
    return float(normalised_squared(error[moving], P[moving]).mean())


def verdicts(found: Sequence[Found]) -> list[Check]:
    """Over all cuts together."""
    left = np.array([f.estimate / f.start for f in found])
    tracker = np.array([f.tracker / f.start for f in found])
    consistent = [
        float(np.mean([f.nees for f in found if f.task == task]))
        for task in dict.fromkeys(f.task for f in found)
    ]
    return [
        _bounded("estimate after five updates over k = 0: worst", left.max(), WORST),
        _bounded("the same: median", float(np.median(left)), MEDIAN),
        _bounded("tracker after five updates over k = 0: worst", tracker.max(), TRACKER),
        _bounded("NEES of the tool, mean of the worst contour", max(consistent), NEES),
        all_hold("the estimate never ends above k = 0", left <= 1.0),
        all_hold("never done while the truth has grown", [not f.silent for f in found]),
    ]


def _bounded(statement: str, value: float, bar: float) -> Check:
    return Check("", f"{statement}: at most {bar:g} ({value:.3f})", "", value, high=bar)
