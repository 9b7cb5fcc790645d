"""Cuts learned from the tool's path: what claims take from the estimator, in one place."""

from dataclasses import dataclass, replace

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.ilc.estimation.consistency import normalised_squared
from armside.ilc.estimation.kalman import Smoother
from armside.ilc.estimation.process import Process, sampled_noise
from armside.sim.estimation.arm_filter import BIAS_WALK
from armside.sim.estimation.deflection import Deflection, explained
from armside.sim.estimation.elasticity import SpringPrior as SpringPrior
from armside.sim.estimation.estimator import ToolEstimator
from armside.sim.estimation.imu_health import REST, repaired
from armside.sim.estimation.imu_health import ImuError as ImuError
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.estimation.rigid_motion import RigidMotion, rigid_motion
from armside.sim.estimation.tool_law import ToolLawKind as ToolLawKind
from armside.sim.instruments.imu import ImuCfg, ImuSamples
from armside.sim.laser.comparison import COMPARED, Case, rms
from armside.sim.laser.experiment import Iteration, Pass
from armside.sim.laser.loop import iterate
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import Source, ToolOutput, ToolPath
from armside.sim.notes import Tally


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


JERK = 60.0
"""Intensity's root of the twist's third derivative [rad/s^3/sqrt(Hz)] times 1e-3: a twist of 60
microradians at 7 Hz, the motion the arm shows. ESTIMATE."""
TWIST = 1e-4  # Standard deviation of the pseudo-measurement f = 0 [rad]


def kinematic_deviation(known: ToolEstimator, motion: RigidMotion, samples: ImuSamples) -> Array:
    """(K, 6): displacement and rotation of the tool by twist, at the IMU's instants: the negative
    control, motor angles and IMU joined without a model of the arm's dynamics.

        x = (f, f', f'', accelerometer low-pass (6), gyro low-pass (6), b_a (3), b_g (3))

    f is the twist of each axis, driven by white jerk and held near zero by a pseudo-measurement;
    the IMU reads rigid kinematics of motor angle plus twist. No mass, no stiffness: at the
    frequencies of a cut the accelerometer alone cannot tell a micrometre. Add it to the tool path
    of rigid kinematics. Of `known` only directions, IMU and clock are used.
    """
    arm, imu = known.models[0].arm, known.imu
    axes, a = arm.axes, len(arm.axes)
    still = np.zeros((len(motion.time), arm.n_free))
    rigid = explained(motion, Deflection(still, still, still), imu)
    at = samples.time + known.parameters.clock_offset
    reading = np.hstack((samples.acceleration, samples.angular_velocity))
    left = reading - rigid(np.clip(at, motion.time[0], motion.time[-1]))

    # One matrix: twist chain, low-passes driven by it, biases.
    J, tilt, none = arm.imu_jacobian[:, axes], arm.imu_gravity[:, axes], np.zeros((3, a))
    low, bias = 3 * a, 3 * a + 12
    size = bias + 6
    A, W = np.zeros((size, size)), np.zeros((size, size))
    A[: 2 * a, a:low] = np.eye(2 * a)
    W[range(2 * a, low), range(2 * a, low)] = (1e-3 * JERK) ** 2
    for k, triad in enumerate((imu.accelerometer, imu.gyroscope)):
        x, rate = low + np.arange(6 * k, 6 * k + 3), low + np.arange(6 * k + 3, 6 * k + 6)
        omega = 2.0 * np.pi * triad.bandwidth
        A[x, rate] = 1.0
        A[rate, x], A[rate, rate] = -(omega**2), -np.sqrt(2.0) * omega
        A[rate, :low] = omega**2 * np.hstack((tilt, none, J[:3]) if k == 0 else (none, J[3:], none))
        W[rate, rate] = omega**4 * triad.noise_density**2 / 2.0
    C = np.zeros((6 + a, size))
    C[range(6), low + np.array([0, 1, 2, 6, 7, 8])] = 1.0
    C[range(6), range(bias, size)] = 1.0
    C[range(6, 6 + a), range(a)] = 1.0
    walk = np.repeat([BIAS_WALK, 0.1 * BIAS_WALK], 3)
    W[range(bias, size), range(bias, size)] = walk**2
    Ad, Q = sampled_noise(A, W, 1.0 / imu.rate)
    R = np.diag(np.r_[np.diag(known.models[0].reading_covariance), np.full(a, TWIST**2)])
    P = np.diag(np.repeat([1e-14, 1e-12, 1e-6, 1e-2], [a, a, a, 18]))
    start = np.zeros(size)
    start[bias:] = np.nanmean(left[at < REST], axis=0)
    y = np.hstack((left, np.zeros((len(left), a))))
    states = Smoother(Process(A=Ad, Q=Q, C=C, R=R), P, np.isfinite(y))(y, start)
    return states.smoothed[:, :a] @ arm.tool_jacobian[:, axes].T
