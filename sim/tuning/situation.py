"""Sensors of the reward, state of an episode after a run, and the next iteration of learning.

A sensor is set up by the first run of an episode, the one without learning, and reads every run.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.ilc.divergence import DIVERGENCE_RATIO, has_diverged
from armside.ilc.measures.norms import inf_norm, two_norm

from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import ImuCfg
from ..instruments.laser_tracker import beam
from ..laser.design import Design
from ..laser.experiment import Experiment, Pass, true_tool_error
from ..laser.loop import FROM_A_MODEL
from ..motion.tool_motion import ToolMotion
from ..notes import Note
from ..robot.recording import saturation
from ..twin.prediction import Corrected
from .action import REACH, Coefficients
from .episode_task import Task

if TYPE_CHECKING:
    from ..laser.tool_measure import ToolOutput

Reading = Callable[[Pass], ToolError]
Sensor = Callable[[Experiment, Pass], Reading]
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

    @property
    def sensor(self) -> Sensor:
        """Set up by the first run of an episode."""
        if self is RewardSensor.TRACKER:
            return _by_tracker
        return _by_motors if self is RewardSensor.MOTOR else _by_estimate

    @property
    def label(self) -> str:
        """Words for tables and axes, after a quantity: "by the tracker"."""
        return f"by the {self.value}{'s' if self is RewardSensor.MOTOR else ''}"

    @property
    def imu(self) -> ImuCfg | None:
        """Configuration of the IMU that the sensor needs at the tool; None without one."""
        return ImuCfg() if self is RewardSensor.ESTIMATE else None


def _by_tracker(experiment: Experiment, _first: Pass) -> Reading:
    return partial(_tracker_error, experiment.motion)


def _tracker_error(motion: ToolMotion, cut: Pass) -> ToolError:
    return tool_error(motion, cut.tracker.time, cut.tracker.position)


def _by_motors(experiment: Experiment, _first: Pass) -> Reading:
    return partial(_motor_error, experiment.cut.cell.robot, experiment.motion)


def _motor_error(robot: kinematics.Robot, motion: ToolMotion, cut: Pass) -> ToolError:
    arm, log = _compiled(robot), cut.recording
    asked, got = (arm.pose(phi)[:, :3, 3] for phi in (log.reference, log.motor_angle))
    # r is shifted against the deflection that the controller expects: compare with r, not
    # with the programmed path.
    return tool_error(motion, log.time, motion.position + got - asked)


def _by_estimate(experiment: Experiment, first: Pass) -> Reading:
    """The assumed payload is right; the gears' springs are those of the nominal robot."""
    # Imported here: the other sensors do without the estimator.
    from ..estimation.commissioning import Commissioning, OnFault
    from ..laser.tool_measure import ToolPath

    measure = ToolPath(stiffness_error=0.0, commissioning=Commissioning(on_fault=OnFault.GO_ON))
    output = measure.commissioned(experiment, measure.assumed(experiment), first)
    return partial(_estimated_error, output, experiment.motion)


def _estimated_error(output: "ToolOutput", motion: ToolMotion, cut: Pass) -> ToolError:
    moved = output.estimated(cut).displacement[:, :3]
    return tool_error(motion, cut.recording.time, motion.position[0] + moved)


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
    task: Task, experiment: Experiment, sensor: Sensor, twin: Corrected | None = None
) -> Situation:
    """Run once without learning, k = 0, corrected by a twin if there is one; set the sensor up."""
    correction = np.zeros_like(experiment.loaded.reference) if twin is None else twin.correction
    cut = experiment.plant.run(correction)
    return _situation(task, experiment, sensor(experiment, cut), 0, correction, cut, twin=twin)


def advance(situation: Situation, decision: Design | Coefficients) -> Situation:
    """Learn once with a design, or take the chosen correction, and run again."""
    centre = situation.centre
    if isinstance(decision, Coefficients):
        correction = centre + decision.correction(len(centre), situation.size)
    else:
        correction = centre + decision.law(situation.correction - centre, situation.error)
    return _run(situation, correction, situation.k + 1)


def run_with(situation: Situation, correction: Array, k: int) -> Situation:
    """Another run k of an episode, with any correction; the episode's noise stays as it is."""
    return _run(restarted(situation), correction, k)


def _run(situation: Situation, correction: Array, k: int) -> Situation:
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
