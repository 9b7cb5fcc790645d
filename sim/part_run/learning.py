"""The learning loop of a whole part: all contours in one run, each judged by itself."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array
from armside.ilc.learning import LoopState
from armside.ilc.workbench.compare import RunState

from ..evaluation.contour_error import ContourError, contour_errors
from ..instruments.noise import rate_of, stride
from ..laser.learning import trials
from ..laser.measures import SetUp
from ..laser.plant import Pass
from ..notes import Note
from ..robot.virtual_robot import LOG_PERIOD
from .experiment import PartExperiment
from .stopping import by_contour, held


@dataclass(frozen=True, kw_only=True)
class PartIteration:
    """One iteration: correction, run, and errors of motors and contours."""

    k: int
    correction: Array = field(repr=False)
    """u_k, (N, 6) [rad], arm side."""
    run: Pass = field(repr=False)
    motor_error: Array = field(repr=False)
    """(N, 6) [rad] of the motor shaft."""
    contours: tuple[ContourError, ...]
    """By the laser tracker."""
    contours_true: tuple[ContourError, ...]
    """By the ground truth."""
    diverged: bool
    notes: tuple[Note, ...] = ()
    converged: tuple[bool, ...]
    """Contours that keep the correction of an earlier iteration."""
    state: LoopState | None = field(default=None, repr=False)
    """State of the loop after it."""


def learn(
    experiment: PartExperiment,
    set_up: SetUp,
    iterations: int,
    *,
    start: Array | None = None,
    resume: RunState | None = None,
    converged: float | None = None,
) -> Iterator[PartIteration]:
    """Iterations k = 0 .. `iterations` of a part, until done or diverged.

    Args:
        set_up: of the measure that is learned from: `measure.prepare(experiment)`.
        start: (N, 6) [rad], correction of the first run; zero if None.
        resume: state after an earlier run, which is gone on from; see `laser.learning.trials`.
        converged: a contour whose learned error falls by less than this fraction in two updates
            running keeps its best correction, and learning ends when all do; None for none.
    """
    start = start if resume is None else resume.start
    zero = np.zeros_like(experiment.loaded.reference)
    first = experiment.plant.run(zero if start is None else start)
    output, motion = set_up(first), experiment.motion
    law = None if converged is None else by_contour(output, motion, converged)
    about = {"law": law, "start": start, "resume": resume}
    found = trials(experiment.plant, output, [first], iterations, **about)
    beam = experiment.job.cutting.beam
    for trial, notes in found:
        (run,), kept = trial.result, held(trial.memory, len(motion.cuts))
        yield PartIteration(
            k=trial.k,
            correction=trial.correction,
            run=run,
            motor_error=run.recording.error * experiment.loaded.model.drives.gear,
            contours=contour_errors(motion, *_tracked(run), beam),
            contours_true=contour_errors(motion, *_true(run), beam),
            diverged=trial.diverged,
            notes=notes,
            state=trial.state,
            converged=kept,
        )
        if all(kept):
            return


def _tracked(run: Pass) -> tuple[Array, Array]:
    """Samples at the log rate: a part is long, and its errors are slow."""
    return _at_log_rate(run.tracker.time, run.tracker.position)


def _true(run: Pass) -> tuple[Array, Array]:
    return _at_log_rate(run.recording.truth.time, run.recording.truth.tool_position)


def _at_log_rate(time: Array, position: Array) -> tuple[Array, Array]:
    every = stride(rate_of(time), 1.0 / LOG_PERIOD)
    return time[::every], position[::every]
