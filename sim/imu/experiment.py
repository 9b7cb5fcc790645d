"""An IMU on a moving robot: what robot and sensor report, and what the kinematics say of it.

Thesis chapter 5. The kinematics see the logged motor angles only; the truth of the recording is for
evaluation.
"""

from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from armside import kinematics
from armside.arrays import Array

from ..instruments.imu import Imu, ImuCfg, ImuSamples, draw
from ..moves.instructions import Program, Wait
from ..moves.planner import JointMotion
from ..robot.linkage import checked_loop_error
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference
from . import Comparison, ProcessingCfg, compare, moving_rms

WINDOW = 0.5
"""Of the moving RMS of the acceleration error [s]. ESTIMATE: the thesis does not give its own."""
SYNCHRONISATION_PAUSE = 1.0
"""A wait this long separates synchronisation and experiment [s]. Thesis 5.3.2 has a short pause."""
MOVING = 1e-4
"""A motor whose reference is slower than this is idle [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class ImuRun:
    """One run, as the robot logged it and the IMU felt it."""

    recording: Recording
    samples: ImuSamples
    imu: Imu
    """The individual, for evaluation only."""


def sense(loaded: LoadedReference, cfg: ImuCfg, seed: int) -> ImuRun:
    """Run a loaded reference once with an IMU on the tool.

    seed: of the robot's noise and of the IMU individual, in separate streams.
    """
    of_robot, of_imu = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    recording = loaded.run(rng=of_robot)
    imu, truth = draw(cfg, of_imu), recording.truth
    samples = imu.measure(truth.time, truth.imu_acceleration, truth.imu_angular_velocity, of_imu)
    return ImuRun(recording=recording, samples=samples, imu=imu)


def without_feedforward(model: RobotModel) -> RobotModel:
    """The robot with a servo that anticipates no torque, of inertia, gravity or friction."""
    return replace(model, drives=replace(model.drives, torque_feedforward=0.0))


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Measured against predicted motion of one run."""

    comparison: Comparison
    window_rms: Array
    """(K, 3) [m/s^2], moving RMS of the acceleration error. Thesis Fig. 5.10."""
    tool_predicted: Array
    """(N, 3) [m], TCP0 from logged motor angles by D-H, at the log's instants."""
    tool: Array
    """(N, 3) [m], true TCP0."""

    @property
    def tool_distance(self) -> Array:
        """(N,) [m], between motor-angle D-H and the tool: elasticity, and encoder resolution."""
        return np.linalg.norm(self.tool - self.tool_predicted, axis=1)


def evaluate(
    run: ImuRun,
    robot: kinematics.Robot,
    with_imu: kinematics.Robot,
    cfg: ProcessingCfg | None = None,
) -> Evaluation:
    """All measures of thesis 5.4.

    Args:
        robot: D-H description down to TCP0.
        with_imu: the same down to the IMU.
    """
    recording = run.recording
    comparison = compare(run.samples, recording.time, recording.motor_angle, with_imu, cfg)
    period = float(comparison.time[1] - comparison.time[0])
    poses = kinematics.compile(robot).pose(np.ascontiguousarray(recording.motor_angle))
    return Evaluation(
        comparison=comparison,
        window_rms=moving_rms(comparison.acceleration_error, WINDOW, period),
        tool_predicted=poses[:, :3, 3],
        tool=recording.truth.tool_position[:: _stride(recording)],
    )


@dataclass(frozen=True, kw_only=True)
class Measures:
    """Numbers of one run; vectors are x, y, z in base axes."""

    since: float
    """Start of what is measured [s]: the end of the synchronisation."""
    angular_velocity_rms: Array
    """Of the error [rad/s]. Thesis Fig. 5.8."""
    angular_velocity_max: Array
    """Of the error [rad/s]."""
    acceleration_rms: Array
    """Of the error [m/s^2]. Thesis Fig. 5.9."""
    acceleration_window_max: Array
    """Largest moving RMS of the error [m/s^2]. Thesis Fig. 5.10."""
    acceleration_window_time: Array
    """When [s]."""
    acceleration_peak: Array
    """Of the measured acceleration, filtered [m/s^2]."""
    clipped_share: float
    """Part of the accelerometer's samples with a component at the end of its range."""
    clock_offset_error: float
    """Of the synchronisation [s]."""
    tool_distance: float
    """Largest distance between motor-angle D-H and the tool [m]. Thesis Fig. 5.7."""
    loop_error: float
    """Widest opening of a closed chain [m]."""
    idle_peaks: Array
    """(6,) [rad], see `idle_peaks`. Thesis 5.3.2."""


def measure(
    run: ImuRun, evaluation: Evaluation, mj: mujoco.MjModel, *, since: float = 0.0
) -> Measures:
    """All numbers of one run from the instant `since` [s] on.

    Raises RuntimeError for a closed chain that did not stay closed.
    """
    comparison, recording = evaluation.comparison, run.recording
    late = comparison.time >= since
    omega, a = comparison.angular_velocity_error[late], comparison.acceleration_error[late]
    window = evaluation.window_rms[late]
    stride = _stride(recording)
    return Measures(
        since=since,
        angular_velocity_rms=_rms(omega),
        angular_velocity_max=np.abs(omega).max(axis=0),
        acceleration_rms=_rms(a),
        acceleration_window_max=window.max(axis=0),
        acceleration_window_time=comparison.time[late][window.argmax(axis=0)],
        acceleration_peak=np.abs(comparison.acceleration_measured[late]).max(axis=0),
        clipped_share=float(run.samples.acceleration_clipped.any(axis=1).mean()),
        clock_offset_error=comparison.clock_offset - run.imu.clock_offset,
        tool_distance=float(evaluation.tool_distance.max()),
        loop_error=checked_loop_error(mj, recording.truth.qpos[::stride]),
        idle_peaks=idle_peaks(recording),
    )


def under_way(motion: JointMotion, time: Array, speed: float) -> NDArray[np.bool_]:
    """(K,) whether a move programmed at this speed along its path [m/s] is under way at `time`."""
    flag = np.zeros(len(time), dtype=bool)
    for report in motion.reports:
        if report.programmed.path == speed:
            flag |= (time >= report.start) & (time <= report.end)
    return flag


def synchronised_at(program: Program, motion: JointMotion) -> float:
    """End of the first long wait after a move [s]: what comes before synchronises the clocks.

    0 for a program without one: all of it is the experiment.
    """
    moved = False
    for index, instruction in enumerate(program.instructions):
        if not isinstance(instruction, Wait):
            moved = True
        elif moved and instruction.seconds >= SYNCHRONISATION_PAUSE:
            later = [report.start for report in motion.reports if report.instruction > index]
            return min(later, default=0.0)
    return 0.0


def _rms(error: Array) -> Array:
    return np.sqrt(np.mean(error**2, axis=0))


def idle_peaks(recording: Recording) -> Array:
    """How far each motor is pushed while others move, (6,) [rad], from the log. Thesis 5.3.2.

    For every move of another motor, the largest departure of an idle motor from where it was when
    that move began. NaN for a motor that is never idle while another moves.
    """
    period = float(recording.time[1] - recording.time[0])
    moving = np.abs(np.gradient(recording.reference, period, axis=0)) > MOVING
    peaks = np.full(6, np.nan)
    for start, stop in _stretches(np.any(moving, axis=1)):
        for axis in np.flatnonzero(~moving[start:stop].any(axis=0)):
            angle = recording.motor_angle[start:stop, axis]
            peaks[axis] = np.fmax(peaks[axis], np.abs(angle - angle[0]).max())
    return peaks


def _stretches(flag: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(first, one past last) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flag, [False]))))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _stride(recording: Recording) -> int:
    return round((len(recording.truth.time) - 1) / (len(recording.time) - 1))
