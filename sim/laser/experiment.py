"""One learning experiment: a task on one robot individual, iteration by iteration."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array
from armside.ilc import learning
from armside.ilc.laws.law import Law

from ..cell import Cell
from ..cut.task import CutTask
from ..cut.tool_motion import ToolMotion
from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import ImuCfg, draw
from ..instruments.laser_tracker import LaserTrackerCfg, set_up
from ..robot.effects import Effect, available, with_effects
from ..robot.individual import Individual, with_friction, with_individual
from ..robot.model import RobotModel
from ..robot.run import LoadedReference
from ..robot.statics import Statics
from ..robot.virtual_robot import VirtualRobot
from .plant import CuttingPlant, MountedImu, Pass, plan


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """Everything that is fixed before the first run."""

    task: CutTask
    motion: ToolMotion
    loaded: LoadedReference
    plant: CuttingPlant


@dataclass(frozen=True, kw_only=True)
class Iteration:
    """One iteration: the trial, and the tool as the tracker and as the truth has it."""

    trial: learning.Trial[Pass]
    motor_error: Array = field(repr=False)
    """(N, 6) [rad] of the motor shaft, before the gear. Thesis 9.2.3."""
    arm: ToolError
    """From tracker samples."""
    arm_true: ToolError


def prepare(
    cell: Cell,
    nominal: RobotModel,
    task: CutTask,
    *,
    seed: int,
    friction_spread: float = 0.02,
    hardware: RobotModel | None = None,
    individual: Individual | None = None,
    repetition: int = 0,
    without: Collection[Effect] = (),
    imu: ImuCfg | None = None,
) -> Experiment:
    """Draw the robot individual, set up the tracker and load the motion.

    Args:
        nominal: the robot as its controller knows it.
        seed: of the individual, of the tracker's set-up and of all noise, in separate streams.
        friction_spread: friction of each axis is uniform within +- this part of the nominal.
        hardware: the robot as it is, where it is not what its controller knows.
        individual: in place of one that only differs in friction.
        repetition: of the same experiment: other noise, everything else alike.
        without: effects of gears and drives to leave out, for ablations.
        imu: the kind of unit to mount at the tool.

    Raises:
        ValueError: the task leaves the joint limits (where) or the reach (by how much).
    """
    drawing, tracking, noise, mounting, reading = np.random.SeedSequence(seed).spawn(5)
    if repetition:
        noise, reading = (stream.spawn(repetition)[-1] for stream in (noise, reading))
    known = Statics(nominal)
    motion, reference = plan(cell, known, task.path, task.pose.quaternion, task.speed, task.limits)
    real = hardware or nominal
    real = with_effects(real, available(real) - frozenset(without), phi=reference[0])
    if individual is not None:
        real = with_individual(real, individual)
    else:
        factor = np.random.default_rng(drawing).uniform(-friction_spread, friction_spread, 6)
        real = with_friction(real, 1.0 + factor)
    loaded = VirtualRobot(real, nominal=known).load(reference)
    tracker = set_up(LaserTrackerCfg(), np.random.default_rng(tracking))
    unit = None
    if imu is not None:
        drawn = draw(imu, np.random.default_rng(mounting))
        unit = MountedImu(drawn, np.random.default_rng(reading))
    plant = CuttingPlant(loaded, tracker, np.random.default_rng(noise), unit)
    return Experiment(task=task, motion=motion, loaded=loaded, plant=plant)


def iterate(experiment: Experiment, law: Law, iterations: int) -> Iterator[Iteration]:
    """Run and learn, k = 0 .. iterations, until done or diverged."""
    loaded = experiment.loaded
    trials = learning.learn(
        experiment.plant,
        law,
        loaded.reference,
        iterations,
        output_of=lambda run: run.recording.motor_angle,
    )
    for trial in trials:
        yield judged(experiment, trial)


def judged(experiment: Experiment, trial: learning.Trial[Pass]) -> Iteration:
    """A trial with its measures on motor and arm side."""
    loaded, motion = experiment.loaded, experiment.motion
    stride = round(1.0 / (experiment.plant.tracker.cfg.rate * loaded.model.timestep))
    truth, seen = trial.result.recording.truth, trial.result.tracker
    return Iteration(
        trial=trial,
        motor_error=trial.result.recording.error * loaded.model.drives.gear,
        arm=tool_error(motion, seen.time, seen.position),
        arm_true=tool_error(motion, truth.time[::stride], truth.tool_position[::stride]),
    )
