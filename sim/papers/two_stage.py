"""Two-stage learning of Chen and Tomizuka on an arm: reference and torque, motor or load side.

W. Chen, M. Tomizuka, IEEE Trans. Control Systems Technology 22(4), 2014; on one joint
`armside.ilc.dual_stage`. Each axis is a two-mass model of the nominal arm at the start. A
correction is (N, 2 n): of the reference [rad], and torque [N m], both on the arm side. The servo's
own input of corrections has a delay and no torque, so the corrected reference is loaded as a
program, whose feedforward is then that of what was learned, and the torque is added to it. Load
angles are estimated as in their estimator.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.ilc.dual_stage import by_frequency, laplace
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.models.elastic_bench import Response, TwoMass

from ..estimation.linearised_arm import linearised
from ..estimation.nominal import NominalArm, assumed_arm
from ..laser.experiment import CuttingPlant, Experiment, Pass, prepare
from ..laser.loop import iterate
from ..laser.measures import SetUp
from ..laser.strokes import Strokes, by_run, robot_of
from ..laser.tool_measure import ToolPath
from ..motion.tool_motion import joint_reference
from ..robot.model import RobotModel
from ..robot.servo import interpolate
from ..robot.statics import Statics, smoothed
from ..robot.virtual_robot import LOG_PERIOD, VirtualRobot
from .joint_estimate import ACCELEROMETER, OFFLINE, STEP, JointEstimator, signals

WITHIN = 0.8
"""Cutoff of Q over the locked frequency of an axis, at most what the accelerometer is smoothed to.
Beyond it in the paper, by how much is not printed. On individual 0 of the M16iB-like arm, whose
axes are coupled, the load side diverges with 0.64, 0.8 and 1.2, the motor side with 1.2."""
FROM_REST = 0.1, 0.4
"""[s], over which a correction begins: a program starts at rest, where its drives hold the arm."""
SIDES = ("load", "motor")
EVERY = round(LOG_PERIOD / STEP)


@dataclass(frozen=True, kw_only=True)
class TwoStagePass(Pass):
    """A pass, and the torque of its feedback."""

    feedback: Array
    """(N, n) [N m], arm side: of the drives, less feedforward and what was learned."""


@dataclass(frozen=True)
class FirstInput:
    """Input of the first run from the nominal model, sag and torsion of the gears compensated."""

    load: Array
    """(N, n) [rad], load angles of the programmed path."""
    motor: Array
    """(N, n) [rad], motor angles for them, at which each gear carries its load."""


def assumed(experiment: Experiment) -> NominalArm:
    """The arm that law, estimator and first input know: as wrong as that of our own laws."""
    return assumed_arm(experiment.nominal, ToolPath().stiffness_error, experiment.seed)


def first_input(experiment: Experiment) -> FirstInput:
    """For the programmed path of an experiment."""
    cell, robot = experiment.cut.cell, experiment.nominal
    start = experiment.loaded.reference[0]
    load = joint_reference(experiment.motion, cell.robot, cell.limits, start=start)
    _, rate, acceleration = interpolate(load, LOG_PERIOD, 1)
    carried = Statics(robot).rigid_forces(load, rate, acceleration)[:, robot.flex]
    return FirstInput(load, load + smoothed(carried / assumed(experiment).stiffness))


@dataclass(frozen=True)
class TwoStagePlant:
    """Runs corrections of reference and torque, from a first reference (N, n) [rad] on."""

    experiment: Experiment
    first: Array

    @cached_property
    def _robot(self) -> VirtualRobot:
        nominal = Statics(self.experiment.nominal)
        return VirtualRobot(self.experiment.loaded.model, nominal=nominal)

    def run(self, correction: Array, /) -> TwoStagePass:
        plain = self.experiment.plant
        time = plain.loaded.log_period * np.arange(len(correction))
        begun = np.clip((time - FROM_REST[0]) / (FROM_REST[1] - FROM_REST[0]), 0.0, 1.0)
        reference, torque = np.hsplit((begun**2 * (3.0 - 2.0 * begun))[:, None] * correction, 2)
        loaded = self._robot.load(self.first + reference)
        fed = interpolate(torque, LOG_PERIOD, loaded.ratio)[0] / loaded.model.drives.gear
        controls, gear = loaded.controls.copy(), loaded.model.drives.gear
        controls[:, 2::3] += fed
        known = controls[:: loaded.ratio, 2::3] * gear
        done = CuttingPlant(
            replace(loaded, controls=controls), plain.tracker, plain.rng, plain.imu
        ).run(np.zeros_like(reference))
        feedback = done.recording.motor_torque * gear - known
        return TwoStagePass(
            recording=done.recording, tracker=done.tracker, imu=done.imu, feedback=feedback
        )


@dataclass(frozen=True)
class TwoStage:
    """The measured output and law of one side: load, estimated, or motor."""

    side: str = "load"

    imu = ACCELEROMETER

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise ValueError(f"side must be {' or '.join(SIDES)}, got {self.side!r}")

    def prepare(self, experiment: Experiment) -> SetUp:
        return lambda first: TwoStageOutput(self.side, experiment, first_input(experiment))


@dataclass(frozen=True)
class TwoStageOutput:
    """Output (N, 2 n) of a run: angles of the side [rad], and torque that its model leaves
    unexplained, with the sign of an error [N m]. Neither is filtered: Q is the law's."""

    side: str
    experiment: Experiment
    known: FirstInput

    @cached_property
    def estimator(self) -> JointEstimator:
        return JointEstimator(self.experiment.nominal, assumed(self.experiment))

    @property
    def law(self) -> "TwoStageLaw":
        return self._law

    @cached_property
    def _law(self) -> "TwoStageLaw":
        start = self.experiment.loaded.reference[0]
        axes = two_masses(self.experiment.nominal, self.estimator.arm, start)
        return TwoStageLaw(self.side, tuple(axes))

    @property
    def reference(self) -> Array:
        """Load or motor angles of the first input; no unexplained torque."""
        wanted = self.known.load if self.side == "load" else self.known.motor
        return np.hstack([wanted, np.zeros_like(wanted)])

    def __call__(self, run: Pass) -> Array:
        if not isinstance(run, TwoStagePass):
            raise ValueError("two-stage learning needs runs of its own plant")
        law, log = self.law, run.recording
        angle = log.motor_angle
        if self.side == "load":
            angle, acceleration = self.estimator.smoothed(signals(self.experiment, run))
            angle, acceleration = angle[::EVERY], acceleration[::EVERY]
            taken = law.through(law.torque_of_acceleration, acceleration)
        else:
            taken = law.through(TwoMass.torque_over_motor, angle - angle[0])
        linear = law.through(TwoMass.torque_over_motor, log.reference - log.reference[0])
        return np.hstack([angle, taken - linear - run.feedback])

    def size(self, error: Array) -> Array:
        return np.array([float(np.linalg.norm(error[:, : error.shape[1] // 2]))])


@dataclass(frozen=True)
class Gains:
    """Of the last update, (n,) each."""

    first_error: Array
    """[rad], largest of the first run."""
    unexplained: Array
    """Norm of e_p in the last run."""
    torque: Array
    """g_u."""


@dataclass(frozen=True)
class TwoStageLaw:
    """Law for errors (N, 2 n) of `TwoStageOutput`, with gains and adaptation as printed:

    g_u = clip(6 g_u (|e_p| / |e_p| of the run before - 1), 0.2, 1), from 1 on
    g_r = (1 - 0.8 g_u) min(2 max|e| / max|e| of the first run, 1)

    An error over one that was zero is 1 where it still is zero, else infinite.
    """

    side: str
    axes: tuple[TwoMass, ...]

    @cached_property
    def _Q(self) -> ZeroPhaseButterworth:
        locked = [np.sqrt(axis.k / axis.Jl) / (2.0 * np.pi) for axis in self.axes]
        cutoff = tuple(min(WITHIN * float(f), OFFLINE) for f in locked)
        return ZeroPhaseButterworth(cutoff, LOG_PERIOD)

    def smooth(self, signal: Array) -> Array:
        """Q of each axis, (N, n)."""
        return self._Q(signal)

    def through(self, response: Callable[[TwoMass, Response], Response], signal: Array) -> Array:
        """Signal (N, n) through a response of each axis at s."""
        s = laplace(len(signal), LOG_PERIOD)
        columns = zip(self.axes, signal.T, strict=True)
        return np.column_stack(
            [by_frequency(response(axis, s), column) for axis, column in columns]
        )

    @staticmethod
    def torque_of_acceleration(axis: TwoMass, s: Response) -> Response:
        """tau / q'' at s, of the load."""
        found = axis.torque_over_load(s)
        found[1:] /= s[1:] ** 2
        found[0] = axis.Jm + axis.Jl
        return found

    def _in_measured_units(self, axis: TwoMass, s: Response) -> Response:
        """e_p by unexplained torque: acceleration of the load, or velocity of the motor."""
        if self.side == "load":
            return 1.0 / self.torque_of_acceleration(axis, s)
        found = np.zeros_like(s)
        found[1:] = s[1:] / axis.torque_over_motor(s)[1:]
        return found

    def check(self, n_samples: int, n_columns: int) -> None:
        if n_columns != 2 * len(self.axes):
            raise ValueError(f"a correction needs {2 * len(self.axes)} columns, got {n_columns}")

    def step(
        self, correction: Array, error: Array, memory: Gains | None = None, /
    ) -> tuple[Array, Gains]:
        (r, t), (e, torque) = np.hsplit(correction, 2), np.hsplit(error, 2)
        largest = np.abs(e).max(axis=0)
        size = np.linalg.norm(self.through(self._in_measured_units, torque), axis=0)
        g_u, first = np.ones(len(self.axes)), largest
        if memory is not None:
            first = memory.first_error
            growth = _over(size, memory.unexplained) - 1.0
            g_u = np.clip(6.0 * memory.torque * growth, 0.2, 1.0)
        g_r = (1.0 - 0.8 * g_u) * np.minimum(2.0 * _over(largest, first), 1.0)
        ahead = e
        if self.side == "load":
            ahead = e[0] + self.through(TwoMass.motor_over_load, e - e[0])
        learned = self.smooth(r + g_r * ahead), self.smooth(t + g_u * torque)
        return np.hstack(learned), Gains(first, size, g_u)


def _over(now: Array, before: Array) -> Array:
    """now / before, (n,), none negative."""
    return np.divide(now, before, out=np.where(now > 0.0, np.inf, 1.0), where=before > 0.0)


def two_masses(robot: RobotModel, arm: NominalArm, phi: Array) -> Iterator[TwoMass]:
    """Each axis of an arm at motor angles phi (n,) [rad], as if the others stood still."""
    drives, inertia = robot.drives, robot.mj.dof_armature[robot.motor]
    load = np.diag(linearised(arm, phi).mass)
    viscous = drives.viscous_friction * drives.gear**2
    columns = zip(inertia, load, arm.stiffness, arm.damping, viscous, strict=True)
    for Jm, Jl, k, d, friction in columns:
        yield TwoMass(
            Jm=float(Jm), Jl=float(Jl), k=float(k), d=float(d), N=1.0, viscous=float(friction)
        )


@dataclass(frozen=True)
class TwoStageJob:
    """Ten runs of the square by one individual, learned in two stages."""

    robot: str
    side: str = "load"
    individual: int = 0
    iterations: int = 9

    cost = 12.0

    def run(self) -> dict[str, Array]:
        """As `StrokesJob.run`."""
        measure = TwoStage(self.side)
        cut = Strokes(
            robot=robot_of(self.robot),
            across_tool=True,
            individual=self.individual,
            imu=measure.imu,
            friction_feedforward=1.0,
        )
        experiment = prepare(cut, seed=self.individual)
        runs = iterate(
            experiment,
            measure.prepare(experiment),
            self.iterations,
            plant=TwoStagePlant(experiment, first_input(experiment).motor),
            inputs=2 * experiment.nominal.n_axes,
        )
        return by_run(runs, self.iterations)
