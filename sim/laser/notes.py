"""Notes of a cut: what limits and faults made of it."""

from collections.abc import Iterator, Sequence

import numpy as np

from ..evaluation.tool_error import ToolError
from ..instruments.laser_tracker import beam
from ..notes import Cause, Note, together
from ..robot.recording import saturation
from .experiment import Experiment, Iteration, Pass

GROWTH = 1.05
"""Error of the tool over that at k = 0 from which on it is noted: above the tracker's noise."""
NAMED = 3
"""Contours that a note names at most."""


def notes(experiment: Experiment, iterations: Sequence[Iteration]) -> list[Note]:
    """Notes of an experiment and of its iterations, each once."""
    of_runs = [note for it in iterations for note in iteration_notes(experiment, it)]
    last = iterations[-1]
    return all_notes(
        experiment, of_runs, iterations[0].contours, () if last.diverged else last.contours
    )


def all_notes(
    experiment: Experiment,
    of_runs: Sequence[Note],
    first: Sequence[ToolError],
    last: Sequence[ToolError],
) -> list[Note]:
    """Each note once: of the plan, of the runs, and of contours that learning made worse.

    first, last: errors of the contours at the first and the last iteration; none of a run that
    diverged.
    """
    cut, motion = experiment.cut, experiment.motion
    names = [contour.name for contour in cut.contours(motion)]
    return together([*cut.notes(motion), *of_runs, *_growth(names, first, last)])


def iteration_notes(experiment: Experiment, iteration: Iteration) -> list[Note]:
    """Notes of one iteration."""
    found = (*pass_notes(experiment, iteration.run), *iteration.notes)
    return [note.at(iteration.k) for note in found]


def pass_notes(experiment: Experiment, run: Pass) -> Iterator[Note]:
    """Notes of one run."""
    yield from saturation(run.recording)
    yield from beam(run.tracker)
    if run.imu is None or experiment.cut.imu is None:
        return
    from ..estimation.imu_health import ImuError, repaired

    try:
        samples = repaired(run.imu, experiment.cut.imu)
    except ImuError as error:
        yield Note(cause=Cause.IMU, text=f"{error}; they are not used")
        return
    if np.isnan(samples.acceleration).any():
        yield Note(cause=Cause.IMU, text="lost or clipped samples of the IMU are bridged")


def named(names: Sequence[str]) -> str:
    """The first of several names, and how many more there are."""
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def _growth(
    names: Sequence[str], first: Sequence[ToolError], last: Sequence[ToolError]
) -> Iterator[Note]:
    """The tool against its first run: what is learned from may be blind to it."""
    worse = [i for i, after in enumerate(last) if after.rms > GROWTH * first[i].rms]
    if not worse:
        return
    rms = f"RMS {1e6 * first[0].rms:.4g} to {1e6 * last[0].rms:.4g} um"
    text = f"learning made the tool worse: {rms}"
    if len(names) > 1:
        of = [names[i] for i in worse]
        text = f"learning made {len(of)} of {len(names)} contours worse: {named(of)}"
    yield Note(cause=Cause.TOOL, text=text)
