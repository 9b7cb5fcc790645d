"""The cutting experiment: a robot individual with its reference, under its instruments.

What is fixed before the first run, one run, and one iteration of learning.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Generic

import numpy as np

from armside.arrays import Array
from armside.ilc.workbench.compare import RunState

from ..evaluation.motion_error import MotionError
from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import Imu, ImuSamples
from ..instruments.imu import draw as draw_imu
from ..instruments.laser_tracker import LaserTracker, LaserTrackerCfg, TrackerSamples, set_up
from ..motion.tool_motion import ToolMotion
from ..notes import Note
from ..robot.drives import gear_error_of
from ..robot.effects import available
from ..robot.individual import Individual, embodied, with_payload
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference
from ..robot.spread import Drawn, Spread, check_applies
from ..robot.statics import Statics
from ..robot.virtual_robot import VirtualRobot
from .specification import MotionT, Setup


def of_motion(time: Array, clock: tuple[Array, Array] | None) -> Array:
    """Times of a motion [s] at which it is where a run is at `time` [s]; clock: as of `Pass`."""
    if clock is None:
        return time
    run, motion = clock
    return np.interp(time, run, motion) + np.maximum(time - run[-1], 0.0)


@dataclass(frozen=True, kw_only=True)
class Pass:
    """One pass over the contour: recorded signals and samples of the instruments."""

    recording: Recording
    tracker: TrackerSamples
    imu: ImuSamples | None = None
    clock: tuple[Array, Array] | None = None
    """(P,) [s] of the run, and of the experiment's motion at the same places, where they differ."""

    def of_motion(self, time: Array) -> Array:
        """As the function of that name."""
        return of_motion(time, self.clock)

    @property
    def tracked(self) -> tuple[Array, Array]:
        """Times of the motion (K,) [s] and positions (K, 3) [m] of the tool by the tracker."""
        return self.of_motion(self.tracker.time), self.tracker.position

    @property
    def true(self) -> tuple[Array, Array]:
        """The same of the ground truth, at the rate of the tracker."""
        truth, seen = self.recording.truth, self.tracker.time
        step = float((seen[1] - seen[0]) / (truth.time[1] - truth.time[0]))
        every = slice(None, None, round(step))
        return self.of_motion(truth.time[every]), truth.tool_position[every]


@dataclass(frozen=True)
class MountedImu:
    """A unit at the tool, with noise of its own."""

    unit: Imu
    rng: np.random.Generator

    def read(self, recording: Recording) -> ImuSamples:
        """Samples of a run."""
        truth = recording.truth
        return self.unit.measure(
            truth.time, truth.imu_acceleration, truth.imu_angular_velocity, self.rng
        )


@dataclass(frozen=True)
class CuttingPlant:
    """Plant of a learning loop: a loaded reference under a laser tracker, with an IMU if wanted."""

    loaded: LoadedReference
    tracker: LaserTracker
    rng: np.random.Generator
    """Source of torque and tracker noise."""
    imu: MountedImu | None = None

    def run(self, correction: Array, /) -> Pass:
        """Cut once with a correction."""
        recording = self.loaded.run(correction, self.rng)
        truth = recording.truth
        tool = truth.tool_position, truth.tool_quaternion
        samples = self.tracker.measure(truth.time, *tool, self.rng)
        imu = None if self.imu is None else self.imu.read(recording)
        return Pass(recording=recording, tracker=samples, imu=imu)


@dataclass(frozen=True, kw_only=True)
class Experiment(Generic[MotionT]):
    """Everything that is fixed before the first run: of a cut with one contour or many."""

    cut: Setup[MotionT]
    seed: int
    individual: Individual = field(repr=False)
    """Parameters of the robot, without drift."""
    nominal: RobotModel = field(repr=False)
    """Nominal robot of the controller."""
    added_payload: float
    """Known mass of the tool beside that of the robot's file [kg]."""
    motion: MotionT = field(repr=False)
    loaded: LoadedReference = field(repr=False)
    plant: CuttingPlant = field(repr=False)

    @property
    def programmed(self) -> Array:
        """(N, 3) [m], positions of the tool."""
        motion: Any = self.motion
        return motion.position

    @property
    def turn_rate(self) -> float:
        """[turns/s], of the contour that is learned; of several, of the fastest."""
        return self.cut.turn_rate(self.motion)

    @property
    def motion_end(self) -> int:
        """First sample of the log at which the reference rests again."""
        motion: Any = self.motion
        return int(np.searchsorted(motion.time, motion.motion_end))


@dataclass(frozen=True, kw_only=True)
class Iteration:
    """One iteration: correction, run, and errors of motors and tool."""

    k: int
    correction: Array = field(repr=False)
    """u_k, (N, n) [rad], arm side."""
    error: Array = field(repr=False)
    """Error of the learned output: motor angles (N, n) [rad], arm side, or path of the tool (N, 6)
    [m], [rad]."""
    run: Pass = field(repr=False)
    motor_error: Array = field(repr=False)
    """(N, n) [rad] of the motor shaft, before the gear. Thesis 9.2.3."""
    tool: ToolError
    """Of all contours, from tracker samples; `tool_true` from the ground truth."""
    tool_true: ToolError
    contours: tuple[ToolError, ...] = field(repr=False)
    contours_true: tuple[ToolError, ...] = field(repr=False)
    """Of each contour."""
    measured_motion: Callable[[], MotionError] = field(repr=False)
    """Computes `motion_error`, which takes a tenth of a run."""
    diverged: bool
    converged: tuple[bool, ...] = ()
    """Contours that keep the correction of an earlier iteration."""
    notes: tuple[Note, ...] = ()
    """Notes of the learning loop."""
    state: RunState | None = field(default=None, repr=False)
    """State that learning can go on from after it; None where it has none."""

    @cached_property
    def motion_error(self) -> MotionError:
        """Of the whole record, from the ground truth."""
        return self.measured_motion()


def prepare(
    cut: Setup[MotionT],
    *,
    seed: int = 0,
    repetition: int = 0,
    nominal: RobotModel | None = None,
    planned: Callable[[Statics], tuple[Any, Array]] | None = None,
) -> Experiment[MotionT]:
    """Plan the motion, draw the robot individual, set up the instruments and load the reference.

    Args:
        seed: of the tracker's set-up, of all noise and, where the cut has no individual, of the
            robot's friction, in separate streams.
        repetition: of the same experiment: other noise, everything else alike.
        nominal: the cut's model, where it is loaded already; with the tool of its file.
        planned: motion and reference (N, n) [rad] on the controller's nominal robot, in place of
            those of the cut.

    Raises:
        ValueError: the cut leaves the joint limits (where) or the reach (by how much), the robot
            cannot carry its payload, or the cut's model is that of another robot.
    """
    drawing, tracking, noise, mounting, reading = np.random.SeedSequence(seed).spawn(5)
    if repetition:
        noise, reading = (stream.spawn(repetition)[-1] for stream in (noise, reading))
    design = cell_model(cut.cell, cut.model) if nominal is None else nominal
    known = controlled(cut, design)
    statics = Statics(known)
    motion, reference = (planned or cut.planned)(statics)
    if cut.gear_error:
        reference = reference - gear_error_of(cut.gear_error, design.n_axes)(reference)
    individual = _individual(cut, np.random.default_rng(drawing), design)
    real = embodied(
        design,
        replace(individual, friction=individual.friction * (1.0 + cut.friction_drift)),
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
    added = 0.0
    if cut.payload is not None and cut.payload_known:
        added = cut.payload - float(design.mj.body("tool").mass[0])
    return Experiment(
        cut=cut,
        seed=seed,
        individual=individual,
        nominal=known,
        added_payload=added,
        motion=motion,
        loaded=loaded,
        plant=CuttingPlant(loaded, tracker, np.random.default_rng(noise), unit),
    )


def controlled(setup: Setup, design: RobotModel) -> RobotModel:
    """The nominal robot of the controller, with the payload that it knows."""
    carrying = design if setup.payload is None else with_payload(design, setup.payload)
    known = carrying if setup.payload_known else design
    if setup.friction_feedforward is None:
        return known
    drives = replace(known.drives, friction_feedforward=setup.friction_feedforward)
    return replace(known, drives=drives)


def _individual(setup: Setup, rng: np.random.Generator, design: RobotModel) -> Individual:
    given, spread = setup.individual, setup.friction_spread
    if given is None:
        return Individual(friction=1.0 + rng.uniform(-spread, spread, design.n_axes))
    if isinstance(given, Individual):
        check_applies(design, given)
        return given
    return (given if isinstance(given, Drawn) else Drawn(given, Spread())).of(design)


def true_tool_error(motion: ToolMotion, run: Pass) -> ToolError:
    """Tool error from the ground truth, at the rate of the tracker."""
    return tool_error(motion, *run.true)
