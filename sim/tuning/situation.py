"""State of an episode after a run, and the next iteration of learning."""

import copy
from dataclasses import dataclass, field, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.divergence import has_diverged
from armside.ilc.measures.norms import inf_norm, two_norm

from ..evaluation.tool_error import ToolError
from ..laser.design import Design
from ..laser.experiment import Experiment, true_tool_error
from ..laser.plant import Pass
from .sensor import Reading, Sensor
from .task import Task


@dataclass(frozen=True)
class Situation:
    """State of an episode after run k."""

    task: Task
    experiment: Experiment
    reading: Reading = field(repr=False)
    """Measures the tool's deviation in a run with the configured sensor."""
    k: int
    correction: Array = field(repr=False)
    """u_k, (N, 6) [rad], arm side."""
    error: Array = field(repr=False)
    """e_k, (N, 6) [rad], arm side."""
    motor_error: Array = field(repr=False)
    """e_k of the motor shafts, (N, 6) [rad]."""
    two_norm: Array
    """(6,) [rad], of `motor_error`; `inf_norm` alike."""
    inf_norm: Array
    first_norm: Array
    """(6,) [rad], `two_norm` at k = 0."""
    measured: ToolError
    """Deviation of the tool as measured by the configured sensor."""
    true: ToolError
    """Ground truth of that deviation: for evaluation only."""
    diverged: bool


def begin(task: Task, experiment: Experiment, sensor: Sensor) -> Situation:
    """Run once without learning, k = 0, and set the sensor up by it."""
    correction = np.zeros_like(experiment.loaded.reference)
    cut = experiment.plant.run(correction)
    return _situation(task, experiment, sensor(experiment, cut), 0, correction, cut)


def advance(situation: Situation, design: Design) -> Situation:
    """Learn once with a design and run again."""
    correction = design.law(situation.correction, situation.error)
    cut = situation.experiment.plant.run(correction)
    fixed = situation.task, situation.experiment, situation.reading
    return _situation(*fixed, situation.k + 1, correction, cut, situation.first_norm)


def restarted(situation: Situation) -> Situation:
    """The same situation with noise sources of its own: what follows can be run again, alike."""
    plant = situation.experiment.plant
    plant = replace(plant, rng=copy.deepcopy(plant.rng), imu=copy.deepcopy(plant.imu))
    return replace(situation, experiment=replace(situation.experiment, plant=plant))


def _situation(
    task: Task,
    experiment: Experiment,
    reading: Reading,
    k: int,
    correction: Array,
    cut: Pass,
    first: Array | None = None,
) -> Situation:
    error = cut.recording.error
    motor_error = error * experiment.loaded.model.drives.gear
    norm = two_norm(motor_error)
    first = norm if first is None else first
    norms, diverged = (norm, inf_norm(motor_error), first), has_diverged(norm, first)
    tool = reading(cut), true_tool_error(experiment.motion, cut)
    signals = correction, error, motor_error
    return Situation(task, experiment, reading, k, *signals, *norms, *tool, diverged)
