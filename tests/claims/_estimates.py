"""Cuts learned from the tool's path: what claims take from the estimator, in one place."""

from dataclasses import dataclass, replace

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.ilc.estimation.consistency import normalised_squared
from armside.sim.estimation.elasticity import SpringPrior as SpringPrior
from armside.sim.estimation.imu_health import ImuError as ImuError
from armside.sim.estimation.imu_health import repaired
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.estimation.rigid_motion import rigid_motion
from armside.sim.estimation.tool_law import ToolLawKind as ToolLawKind
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case, rms
from armside.sim.laser.experiment import Iteration, Pass
from armside.sim.laser.loop import iterate
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import Source, ToolOutput, ToolPath
from armside.sim.notes import Tally

from ._kinematic_filter import kinematic_deviation


def rigid_path(run: Pass, robot: kinematics.Robot = kinematics.LARGE_ROBOT) -> Array:
    """(N, 6): path of the tool by rigid kinematics of the measured motor angles, from rest."""
    angle = np.ascontiguousarray(run.recording.motor_angle)
    return relative_to_start(kinematics.compile(robot).pose(angle)[:, :3, 3])


def path_error(path: Array, run: Pass) -> float:
    """RMS distance [m] of a path (N, 6) from the ground truth, at the same instants, from rest."""
    truth = run.recording.truth
    every = round(float(run.recording.time[1] / truth.time[1]))
    true = relative_to_start(truth.tool_position[::every])
    return float(np.sqrt(np.square((path - true)[:, :3]).sum(axis=1).mean()))


BY_TRACKER = replace(COMPARED, source=Source.TRACKER)


@dataclass(frozen=True)
class Learned:
    """Iterations of a cut, and the tool's path that they are learned from."""

    case: Case
    iterations: list[Iteration]
    output: ToolOutput | None = None
    """None where motor angles are learned from."""

    @property
    def um(self) -> list[float]:
        """Tool RMS (9.6) [um] of each iteration, by the tracker."""
        return [1e6 * length for length in rms(self.iterations)]

    @property
    def diverged(self) -> bool:
        return self.iterations[-1].diverged

    def errors(self) -> tuple[float, float]:
        """Error [um] of the first run's path, 3D: by motor-angle kinematics, and estimated."""
        first, arm = self.iterations[0].run, self.case.cut.cell.robot
        assert self.output is not None
        rigid, estimate = rigid_path(first, arm), self.output(first)
        return 1e6 * path_error(rigid, first), 1e6 * path_error(estimate, first)


def case(cut: Cut, seed: int) -> Case:
    """A cut with an IMU at the tool, of one seed."""
    return Case(cut=cut if cut.imu else replace(cut, imu=ImuCfg()), seed=seed)


def from_estimate(of: Case, updates: int, tally: Tally, measure: ToolPath = COMPARED) -> Learned:
    """Learn from the estimate, commissioned by the first run; notes are counted."""
    output, learning = of.from_tool(updates, measure)
    return _counted(Learned(of, list(learning), output), tally)


def from_tracker(of: Learned, updates: int, tally: Tally) -> Learned:
    """The same cut learned from the tracker, with the law on what the estimate has identified."""
    assert of.output is not None
    _, learning = of.case.from_tool(updates, BY_TRACKER, of.output.known.parameters)
    return _counted(Learned(of.case, list(learning), of.output), tally)


def tracked_along(of: Learned, updates: int) -> Learned:
    """The same cut learned from the tracker along the path; its notes are not counted."""
    assert of.output is not None
    output = replace(of.output, measure=replace(of.output.measure, source=Source.TRACKER))
    experiment = of.case.experiment()
    iterations = list(iterate(experiment, lambda _: output, updates))
    return Learned(of.case, iterations, output)


def from_motors(of: Case, updates: int, tally: Tally) -> Learned:
    """The same cut learned from its motors, as the thesis does."""
    return _counted(Learned(of, list(of.from_motors(updates))), tally)


def _counted(learned: Learned, tally: Tally) -> Learned:
    tally.add(notes(learned.case.experiment(), learned.iterations))
    return learned


def nees(of: Learned) -> float:
    """Mean normalised squared error of the estimated position while the arm moves, in run 0.

    3 for an estimator that knows its error.
    """
    output, run = of.output, of.iterations[0].run
    assert output is not None
    log, truth = run.recording, run.recording.truth
    every = round(float(log.time[1] / truth.time[1]))
    error: Array = (output(run) - relative_to_start(truth.tool_position[::every]))[:, :3]
    moving = slice(int(np.argmax(log.time > 0.4)), None)
    P = output.known.tool_covariance(output.experiment.nominal)
    return float(normalised_squared(error[moving], P[moving]).mean())


def kinematic_path(output: ToolOutput, unit: ImuCfg, first: Pass) -> Array:
    """The tool's path by a filter without dynamics."""
    log, estimator = first.recording, output.known.estimator
    assert first.imu is not None
    samples = repaired(first.imu, unit)
    motion = rigid_motion(estimator.arm, log.time, log.motor_angle)
    at = samples.time + estimator.parameters.clock_offset
    twist = kinematic_deviation(estimator, motion, samples)
    moved = np.stack([np.interp(log.time, at, column) for column in twist.T], axis=1)
    return rigid_path(first) + moved
