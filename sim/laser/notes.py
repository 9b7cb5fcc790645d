"""Notes of a cut: what limits and faults made of it."""

from collections.abc import Iterator, Sequence

import numpy as np

from ..estimation.imu_health import ImuError, repaired
from ..instruments.notes import beam
from ..motion.tool_motion import motion_notes
from ..notes import Cause, Note, together
from ..robot.limits import saturation
from .experiment import Experiment, Iteration
from .plant import Pass

GROWTH = 1.05
"""Error of the tool over that at k = 0 from which on it is noted: above the tracker's noise."""


def notes(experiment: Experiment, iterations: Sequence[Iteration]) -> list[Note]:
    """Notes of an experiment and of its iterations, each once."""
    found = [*motion_notes(experiment.motion, experiment.cut.limits)]
    for iteration in iterations:
        of_run = (*pass_notes(experiment, iteration.run), *iteration.notes)
        found += [note.at(iteration.k) for note in of_run]
    return together([*found, *_growth(iterations)])


def pass_notes(experiment: Experiment, run: Pass) -> Iterator[Note]:
    """Notes of one run."""
    yield from saturation(run.recording)
    yield from beam(run.tracker)
    if run.imu is None or experiment.cut.imu is None:
        return
    try:
        samples = repaired(run.imu, experiment.cut.imu)
    except ImuError as error:
        yield Note(cause=Cause.IMU, text=f"{error}; they are not used")
        return
    if np.isnan(samples.acceleration).any():
        yield Note(cause=Cause.IMU, text="lost or clipped samples of the IMU are bridged")


def _growth(iterations: Sequence[Iteration]) -> Iterator[Note]:
    """The tool against its first run: what is learned from may be blind to it."""
    first, last = iterations[0], iterations[-1]
    if not last.diverged and last.tool.rms > GROWTH * first.tool.rms:
        rms = f"{1e6 * first.tool.rms:.4g} to {1e6 * last.tool.rms:.4g} um"
        yield Note(cause=Cause.TOOL, text=f"learning made the tool worse: RMS {rms}")
