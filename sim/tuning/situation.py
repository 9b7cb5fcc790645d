"""Sensors of the reward, state of an episode after a run, and the next iteration of learning.

A sensor is set up by the first run of an episode, the one without learning, and reads every run.
"""

import copy
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.ilc.divergence import DIVERGENCE_RATIO, has_diverged
from armside.ilc.measures.norms import inf_norm, two_norm

from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import ImuCfg
from ..instruments.laser_tracker import beam
from ..laser.experiment import Experiment, Pass, true_tool_error
from ..laser.loop import FROM_A_MODEL
from ..motion.tool_motion import ToolMotion, motion_notes
from ..notes import Note
from ..robot.recording import saturation
from ..twin.prediction import Corrected
from .action import REACH
from .episode_task import Task

if TYPE_CHECKING:
    from ..laser.tool_measure import ToolOutput

_compiled = lru_cache(kinematics.compile)


class RewardSensor(Enum):
    """Sensor that the reward is computed from."""

    TRACKER = "tracker"
    """A laser tracker."""
    ESTIMATE = "estimate"
    """Motor angles and an IMU at the tool; the arm is identified from the first run of an episode,
    which takes seconds."""
    MOTOR = "motor"
    """The motor angles, by rigid forward kinematics."""

    def reading(self, experiment: Experiment, first: Pass) -> "Reading":
        """The sensor of an episode, set up by its first run.

        The estimate assumes the right payload, and the springs of the nominal robot's gears.
        """
        motion, robot = experiment.motion, experiment.cut.cell.robot
        if self is not RewardSensor.ESTIMATE:
            return Reading(self, motion, robot)
        # Imported here: the other sensors do without the estimator.
        from ..estimation.commissioning import Commissioning, OnFault
        from ..laser.tool_measure import ToolPath

        going_on = Commissioning(on_fault=OnFault.GO_ON)
        measure = ToolPath(stiffness_error=0.0, commissioning=going_on)
        output = measure.commissioned(experiment, measure.assumed(experiment), first)
        return Reading(self, motion, robot, output)

    @property
    def label(self) -> str:
        """Words for tables and axes, after a quantity: "by the tracker"."""
        return f"by the {self.value}{'s' if self is RewardSensor.MOTOR else ''}"

    @property
    def imu(self) -> ImuCfg | None:
        """Configuration of the IMU that the sensor needs at the tool; None without one."""
        return ImuCfg() if self is RewardSensor.ESTIMATE else None


@dataclass(frozen=True, eq=False)
class Reading:
    """Measures the tool's deviation in a run of an episode."""

    sensor: RewardSensor
    motion: ToolMotion
    robot: kinematics.Robot
    output: "ToolOutput | None" = None
    """Of the estimate."""

    def __call__(self, cut: Pass) -> ToolError:
        motion, log = self.motion, cut.recording
        if self.sensor is RewardSensor.TRACKER:
            return tool_error(motion, cut.tracker.time, cut.tracker.position)
        if self.output is not None:
            moved = self.output.estimated(cut).displacement[:, :3]
            return tool_error(motion, log.time, motion.position[0] + moved)
        arm = _compiled(self.robot)
        asked, got = (arm.pose(phi)[:, :3, 3] for phi in (log.reference, log.motor_angle))
        # r is shifted against the deflection that the controller expects: compare with r, not
        # with the programmed path.
        return tool_error(motion, log.time, motion.position + got - asked)


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
    """e_k, (N, 6) [rad], arm side: of the reference, or of a twin's motor angles."""
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
    twin: Corrected | None = field(default=None, repr=False)
    """What a twin of the robot learned for the task; None without one."""
    notes: tuple[Note, ...] = ()
    """Limits that the run touched, and a beam that was lost."""

    @property
    def all_notes(self) -> list[Note]:
        """Notes of its motion, then those of the run."""
        made = self.experiment
        return [*motion_notes(made.motion, made.cut.limits), *self.notes]

    @property
    def centre(self) -> Array:
        """(N, 6) [rad], arm side, correction that learning goes around: a twin's, or zero."""
        known = _trusted(self.twin)
        return np.zeros_like(self.correction) if known is None else known.correction

    @property
    def size(self) -> Array:
        """(6,) [rad], arm side, correction of each axis for a coefficient of 1."""
        gear = self.experiment.loaded.model.drives.gear
        return REACH * self.first_norm / np.sqrt(len(self.error)) / gear


def begin(
    task: Task, experiment: Experiment, sensor: RewardSensor, twin: Corrected | None = None
) -> Situation:
    """Run once without learning, k = 0, corrected by a twin if there is one; set the sensor up."""
    correction = np.zeros_like(experiment.loaded.reference) if twin is None else twin.correction
    cut = experiment.plant.run(correction)
    return _situation(
        task, experiment, sensor.reading(experiment, cut), 0, correction, cut, twin=twin
    )


def run(situation: Situation, correction: Array, k: int) -> Situation:
    """Run k of an episode, with any correction."""
    cut = situation.experiment.plant.run(correction)
    fixed = situation.task, situation.experiment, situation.reading
    return _situation(*fixed, k, correction, cut, situation.first_norm, situation.twin)


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
    twin: Corrected | None = None,
) -> Situation:
    known, log = _trusted(twin), cut.recording
    error = log.error if known is None else known.motor_path - log.motor_angle
    motor_error = error * experiment.loaded.model.drives.gear
    norm = two_norm(motor_error)
    first = norm if first is None else first
    ratio = DIVERGENCE_RATIO * (1.0 if known is None else FROM_A_MODEL)
    norms, diverged = (norm, inf_norm(motor_error), first), has_diverged(norm, first, ratio)
    tool = reading(cut), true_tool_error(experiment.motion, cut)
    signals = correction, error, motor_error
    notes = (*saturation(log), *beam(cut.tracker))
    return Situation(task, experiment, reading, k, *signals, *norms, *tool, diverged, twin, notes)


def _trusted(twin: Corrected | None) -> Corrected | None:
    return twin if twin is not None and twin.trusted else None
