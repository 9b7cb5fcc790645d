"""Phases of a motion, and errors of the predicted motion in them: the measures of thesis 5.4.

The kinematics use the logged motor angles only; the true motion is for evaluation.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from armside import kinematics
from armside.arrays import Array

from ..cell import Cell
from ..instruments.imu import Imu, ImuSamples
from ..motion.instructions import Program, Wait
from ..motion.planner import ProgramMotion
from ..robot.linkage import checked_loop_error
from ..robot.recording import Recording
from .measured_beside_predicted import ImuComparison, compare, moving_rms
from .predicted_motion import ProcessingCfg

SYNCHRONISATION_PAUSE = 1.0
"""Shortest wait between synchronisation and experiment [s]. Thesis 5.3.2 has a short pause."""
MOVING = 1e-4
"""A motor whose reference is slower than this is idle [rad/s]."""
SLOW_CIRCLE, FAST_CIRCLE, RECTANGLE = 0.5, 1.0, 5.0
"""Programmed speeds of the parts of the simultaneous motion [m/s]."""


def synchronised_at(program: Program, motion: ProgramMotion) -> float:
    """End of the first long wait after a move [s], before which clocks are synchronised; 0 without
    one."""
    moved = False
    for index, instruction in enumerate(program.instructions):
        if not isinstance(instruction, Wait):
            moved = True
        elif moved and instruction.seconds >= SYNCHRONISATION_PAUSE:
            later = [report.start for report in motion.reports if report.instruction > index]
            return min(later, default=0.0)
    return 0.0


def under_way(motion: ProgramMotion, time: Array, speed: float) -> NDArray[np.bool_]:
    """Instants (K,) [s] at which a move programmed at this path speed [m/s] is under way."""
    flag = np.zeros(len(time), dtype=bool)
    for report in motion.reports:
        if report.programmed.path == speed:
            flag |= (time >= report.start) & (time <= report.end)
    return flag


def idle_peaks(recording: Recording) -> Array:
    """Largest displacement of each motor while only others move, (n,) [rad], from the log.

    For every move of another motor, the largest departure of an idle motor from its angle at the
    start of that move; NaN for a motor that is never idle while another moves. Thesis 5.3.2.
    """
    period = float(recording.time[1] - recording.time[0])
    moving = np.abs(np.gradient(recording.reference, period, axis=0)) > MOVING
    peaks = np.full(recording.reference.shape[1], np.nan)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], moving.any(axis=1), [False]))))
    for start, stop in edges.reshape(-1, 2).tolist():  # of each stretch in which any moves
        for axis in np.flatnonzero(~moving[start:stop].any(axis=0)):
            angle = recording.motor_angle[start:stop, axis]
            peaks[axis] = np.fmax(peaks[axis], np.abs(angle - angle[0]).max())
    return peaks


WINDOW = 0.5
"""Window of the moving RMS of the acceleration error [s]. ESTIMATE: the thesis gives none."""


@dataclass(frozen=True, kw_only=True)
class ImuRun:
    """Recorded signals of one run with an IMU."""

    recording: Recording
    samples: ImuSamples
    imu: Imu
    """The individual, for evaluation only."""


@dataclass(frozen=True)
class Evaluation:
    """Measured and predicted motion of one run."""

    comparison: ImuComparison
    window_rms: Array
    """(K, 3) [m/s^2], moving RMS of the acceleration error. Thesis Fig. 5.10."""
    tool_predicted: Array
    """(N, 3) [m], TCP0 from logged motor angles by D-H, at the log's instants."""
    tool: Array
    """(N, 3) [m], true TCP0."""


def evaluate(run: ImuRun, cell: Cell, cfg: ProcessingCfg, gravity: Array) -> Evaluation:
    """Compare measured with predicted motion, of the IMU and of the tool; gravity as `compare`."""
    recording = run.recording
    logged = recording.time, recording.motor_angle
    comparison = compare(run.samples, *logged, cell.with_imu, cfg, gravity=gravity)
    period = float(comparison.time[1] - comparison.time[0])
    window_rms = moving_rms(comparison.acceleration_error, WINDOW, period)
    tool = recording.truth.tool_position[:: _log_stride(recording)]
    return Evaluation(comparison, window_rms, position(cell.robot, recording.motor_angle), tool)


@dataclass(frozen=True, kw_only=True)
class Measures:
    """Error measures of one run; vectors are x, y, z in base axes."""

    since: float
    """Start of the evaluation [s]: the end of the synchronisation."""
    angular_velocity_rms: Array
    """RMS error [rad/s], beside the largest. Thesis Fig. 5.8."""
    angular_velocity_max: Array
    acceleration_rms: Array
    """RMS error [m/s^2]. Thesis Fig. 5.9."""
    acceleration_window_max: Array
    """Largest moving RMS of the error [m/s^2], and its instant [s]. Thesis Fig. 5.10."""
    acceleration_window_time: Array
    acceleration_peak: Array
    """Largest measured acceleration, filtered [m/s^2]."""
    clipped_share: float
    """Fraction of the accelerometer's samples with a component at the end of its range."""
    clock_offset_error: float
    """Error of the synchronisation [s]."""
    tool_distance: float
    """Largest distance between motor-angle D-H and the tool [m]: elasticity. Thesis Fig. 5.7."""
    loop_error: float
    """Widest opening of a closed chain [m]."""
    idle_peaks: Array
    """(n,) [rad], see `phases.idle_peaks`. Thesis 5.3.2."""


def measure(
    run: ImuRun, evaluation: Evaluation, mj: mujoco.MjModel, *, since: float = 0.0
) -> Measures:
    """Error measures of one run from the instant `since` [s] on. Raises RuntimeError for a closed
    chain that did not stay closed."""
    comparison = evaluation.comparison
    late = comparison.time >= since
    omega, a = comparison.angular_velocity_error[late], comparison.acceleration_error[late]
    window = evaluation.window_rms[late]
    distance = np.linalg.norm(evaluation.tool - evaluation.tool_predicted, axis=1)
    return Measures(
        since=since,
        angular_velocity_rms=rms(omega),
        angular_velocity_max=np.abs(omega).max(axis=0),
        acceleration_rms=rms(a),
        acceleration_window_max=window.max(axis=0),
        acceleration_window_time=comparison.time[late][window.argmax(axis=0)],
        acceleration_peak=np.abs(comparison.acceleration_measured[late]).max(axis=0),
        clipped_share=float(run.samples.acceleration_clipped.any(axis=1).mean()),
        clock_offset_error=comparison.clock_offset - run.imu.clock_offset,
        tool_distance=float(distance.max()),
        loop_error=largest_gap(run.recording, mj),
        idle_peaks=idle_peaks(run.recording),
    )


def position(robot: kinematics.Robot, motor_angle: Array) -> Array:
    """Origin of the last frame (N, 3) [m] in base axes, by D-H from motor angles (N, n) [rad]."""
    return kinematics.compile(robot).pose(np.ascontiguousarray(motor_angle))[:, :3, 3]


def largest_gap(recording: Recording, mj: mujoco.MjModel) -> float:
    """Widest opening of a closed chain at the log's instants [m]. Raises RuntimeError if open."""
    return checked_loop_error(mj, recording.truth.qpos[:: _log_stride(recording)])


def _log_stride(recording: Recording) -> int:
    """Physics steps in one period of the log."""
    return round((len(recording.truth.time) - 1) / (len(recording.time) - 1))


def rms(error: Array) -> Array:
    """Root mean square of the columns."""
    return np.sqrt(np.mean(error**2, axis=0))
