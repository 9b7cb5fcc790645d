"""One experiment: a cut by one robot individual under one tracker, before and after each run."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.learning import Trial

from ..cut.tool_motion import ToolMotion
from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import draw as draw_imu
from ..instruments.laser_tracker import LaserTrackerCfg, set_up
from ..notes import Note
from ..robot.applicable import check_applies
from ..robot.cell_model import cell_model
from ..robot.effects import available
from ..robot.individual import Individual, embodied, with_payload
from ..robot.mjcf import N_AXES
from ..robot.model import RobotModel
from ..robot.run import LoadedReference
from ..robot.spread import Drawn, Spread
from ..robot.statics import Statics
from ..robot.virtual_robot import VirtualRobot
from .plant import CuttingPlant, MountedImu, Pass, plan
from .specification import Cut


@dataclass(frozen=True)
class Experiment:
    """Everything that is fixed before the first run."""

    cut: Cut
    seed: int
    individual: Individual = field(repr=False)
    """Parameters of the robot, without drift."""
    nominal: RobotModel = field(repr=False)
    """Nominal robot of the controller."""
    added_payload: float
    """Known mass of the tool beside that of the robot's file [kg]."""
    motion: ToolMotion = field(repr=False)
    loaded: LoadedReference = field(repr=False)
    plant: CuttingPlant = field(repr=False)

    @property
    def motion_end(self) -> int:
        """First sample of the log at which the reference rests again."""
        motion = self.motion
        return int(np.searchsorted(motion.time, motion.rest_before + motion.timing.duration))


@dataclass(frozen=True, kw_only=True)
class Iteration:
    """One iteration: correction, run, and errors of motors and tool."""

    k: int
    correction: Array = field(repr=False)
    """u_k, (N, 6) [rad], arm side."""
    error: Array = field(repr=False)
    """Error of the learned output: motor angles (N, 6) [rad], arm side, or path of the tool (N, 6)
    [m], [rad]."""
    run: Pass = field(repr=False)
    motor_error: Array = field(repr=False)
    """(N, 6) [rad] of the motor shaft, before the gear. Thesis 9.2.3."""
    tool: ToolError
    """From tracker samples; `tool_true` from the ground truth."""
    tool_true: ToolError
    diverged: bool
    notes: tuple[Note, ...] = ()
    """Notes of the learning loop."""


def prepare(
    cut: Cut, *, seed: int = 0, repetition: int = 0, nominal: RobotModel | None = None
) -> Experiment:
    """Draw the robot individual, set up the tracker and load the motion.

    Args:
        seed: of the tracker's set-up, of all noise and, where the cut has no individual, of the
            robot's friction, in separate streams.
        repetition: of the same experiment: other noise, everything else alike.
        nominal: the cut's model, where it is loaded already; with the tool of its file.

    Raises:
        ValueError: the cut leaves the joint limits (where) or the reach (by how much), the robot
            cannot carry its payload, or the cut's model is that of another robot.
    """
    drawing, tracking, noise, mounting, reading = np.random.SeedSequence(seed).spawn(5)
    if repetition:
        noise, reading = (stream.spawn(repetition)[-1] for stream in (noise, reading))
    design = cell_model(cut.cell, cut.model) if nominal is None else nominal
    carrying = design if cut.payload is None else with_payload(design, cut.payload)
    known = carrying if cut.payload_known else design
    if cut.friction_feedforward is not None:
        drives = replace(known.drives, friction_feedforward=cut.friction_feedforward)
        known = replace(known, drives=drives)
    statics = Statics(known)
    motion, reference = plan(
        cut.cell, statics, cut.path, cut.tool_pose.quaternion, cut.speed, cut.limits
    )
    individual = _individual(cut, np.random.default_rng(drawing), design)
    friction = individual.friction * (1.0 + cut.friction_drift)
    real = embodied(
        design,
        replace(individual, friction=friction),
        available(design) - frozenset(cut.without),
        phi=reference[0],
        payload=cut.payload,
        temperature=cut.temperature,
    )
    loaded = VirtualRobot(real, nominal=statics).load(reference)
    tracker = set_up(LaserTrackerCfg(), np.random.default_rng(tracking))
    unit = None
    if cut.imu is not None:
        imu = draw_imu(cut.imu, np.random.default_rng(mounting))
        unit = MountedImu(imu, np.random.default_rng(reading))
    plant = CuttingPlant(loaded, tracker, np.random.default_rng(noise), unit)
    added = 0.0
    if cut.payload is not None and cut.payload_known:
        added = cut.payload - float(design.mj.body("tool").mass[0])
    return Experiment(cut, seed, individual, known, added, motion, loaded, plant)


def _individual(cut: Cut, rng: np.random.Generator, design: RobotModel) -> Individual:
    individual = cut.individual
    if individual is None:
        spread = cut.friction_spread
        individual = Individual(friction=1.0 + rng.uniform(-spread, spread, N_AXES))
    elif isinstance(individual, int):
        individual = Drawn(individual, Spread()).of(design)
    elif isinstance(individual, Drawn):
        individual = individual.of(design)
    else:
        check_applies(design, individual)
    return individual


def evaluated(
    experiment: Experiment, trial: Trial[Any], run: Pass, notes: tuple[Note, ...] = ()
) -> Iteration:
    """A trial and its run, with errors of motors and tool."""
    motion = experiment.motion
    return Iteration(
        k=trial.k,
        correction=trial.correction,
        error=trial.error,
        run=run,
        motor_error=run.recording.error * experiment.loaded.model.drives.gear,
        tool=tool_error(motion, run.tracker.time, run.tracker.position),
        tool_true=true_tool_error(motion, run),
        diverged=trial.diverged,
        notes=notes,
    )


def true_tool_error(motion: ToolMotion, run: Pass) -> ToolError:
    """Tool error from the ground truth, at the rate of the tracker."""
    truth, seen = run.recording.truth, run.tracker.time
    every = slice(None, None, round(float((seen[1] - seen[0]) / (truth.time[1] - truth.time[0]))))
    return tool_error(motion, truth.time[every], truth.tool_position[every])
