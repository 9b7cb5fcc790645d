"""One cut of `armside verify long-way` as a job: commissioned once, learned from two sensors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import normalised_squared
from armside.sim.cut.contour import Circle, ClosedCurve
from armside.sim.cut.polyline import rounded
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.estimation.tool_law import ToolLaw
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import Case, rms
from armside.sim.laser.experiment import Iteration, Pass
from armside.sim.laser.learning import iterate
from armside.sim.laser.results import GROWTH, notes, status
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import Source
from armside.sim.laser.way_measure import PathAlongWay, WayOutput
from armside.sim.notes import Cause, Note

from ..jobs.store import Result

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
    """The truth has grown, and the run ends as done."""
    notes: tuple[Note, ...]
    """Of the runs from the estimate."""


@dataclass(frozen=True, kw_only=True)
class WayJob:
    """One cut of one seed."""

    seed: int
    pose: str
    task: str

    @property
    def cost(self) -> float:
        """[s], of one run."""
        cut = TASKS[self.task]
        return cut.curve.length / cut.speed

    def run(self) -> Result:
        """Arrays of `Found`."""
        known = Case(cut=replace(TASKS[self.task], pose=self.pose, imu=ImuCfg()), seed=self.seed)
        output, learning = known.from_tool(UPDATES, MEASURE)
        assert isinstance(output, WayOutput)
        iterations, experiment = list(learning), known.experiment()
        by_tracker = replace(output, measure=replace(output.measure, source=Source.TRACKER))
        tracked = list(iterate(experiment, lambda _: by_tracker, UPDATES))
        ended = status(iterations, of_tool=True)
        said = notes(experiment, iterations)
        return {
            "start": np.array(rms(iterations)[0]),
            "estimate": np.array(rms(iterations)[-1]),
            "tracker": np.array(rms(tracked)[-1]),
            "nees": np.array(nees(output, iterations[0].run)),
            "silent": np.array(_grown(iterations) and ended == "done"),
            "causes": np.array([note.cause.value for note in said], dtype=np.str_),
            "texts": np.array([note.text for note in said], dtype=np.str_),
        }


def found_of(job: WayJob, arrays: Result) -> Found:
    """The outcome of a job from its arrays."""
    said = zip(arrays["causes"], arrays["texts"], strict=True)
    return Found(
        seed=job.seed,
        pose=job.pose,
        task=job.task,
        **{name: float(arrays[name]) for name in ("start", "estimate", "tracker", "nees")},
        silent=bool(arrays["silent"]),
        notes=tuple(Note(cause=Cause(str(cause)), text=str(text)) for cause, text in said),
    )


def _grown(iterations: Sequence[Iteration]) -> bool:
    return iterations[-1].tool_true.rms > GROWTH * iterations[0].tool_true.rms


def nees(output: WayOutput, run: Pass) -> float:
    """Mean normalised squared error of the estimated position while the arm moves."""
    log, truth = run.recording, run.recording.truth
    every = round(float(log.time[1] / truth.time[1]))
    error: Array = (output(run) - relative_to_start(truth.tool_position[::every]))[:, :3]
    moving = slice(int(np.argmax(log.time > 0.4)), None)
    P = output.way.tool_covariance(output.experiment.nominal)
    return float(normalised_squared(error[moving], P[moving]).mean())
