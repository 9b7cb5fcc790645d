"""One program of `armside imu`, run for a report or for many seeds: the arrays it leaves."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array
from armside.sim.cell import CELLS
from armside.sim.imu.compare import find_offset
from armside.sim.imu.experiment import under_way
from armside.sim.instruments.imu import ImuCfg, draw
from armside.sim.moves.planner import JointMotion
from armside.sim.robot.recording import Recording

from ..commands.imu import (
    AS_THE_THESIS,
    BEST,
    Done,
    ImuExperimentCfg,
    imu_position,
    prepare,
    processed_again,
    processing,
    run_one,
    run_rest,
)

CLOCKS_APART = 0.4
"""Largest offset of the clocks of `clock_errors` [s]: as far as a start by hand may be off."""
SLOW_CIRCLE, FAST_CIRCLE, RECTANGLE = 0.5, 1.0, 5.0
"""Programmed speeds that tell the parts of the simultaneous motion apart [m/s]."""


def fast_over_slow(done: Done) -> float:
    """RMS of the acceleration error in the rectangle over that in the slow circle."""
    comparison, motion = done.evaluation.comparison, done.prepared.motion
    fast, slow = (
        np.sqrt(np.mean(comparison.acceleration_error[under_way(motion, comparison.time, v)] ** 2))
        for v in (RECTANGLE, SLOW_CIRCLE)
    )
    return float(fast / slow)


def in_the_rectangle(done: Done, time: Array) -> NDArray[np.bool_]:
    """Which of these instants [s] are, the same shape."""
    return under_way(done.prepared.motion, time, RECTANGLE)


def clock_errors(
    cfg: ImuExperimentCfg, recording: Recording, rngs: Sequence[np.random.Generator]
) -> Array:
    """Errors of the clock offsets found on one run, an IMU individual each, (n,) [s]."""
    truth, errors = recording.truth, []
    for rng in rngs:
        sensor = draw(ImuCfg(clock_offset=CLOCKS_APART), rng)
        samples = sensor.measure(
            truth.time, truth.imu_acceleration, truth.imu_angular_velocity, rng
        )
        with_imu = CELLS[cfg.robot].with_imu
        found = find_offset(
            samples, recording.time, recording.motor_angle, with_imu, processing(cfg)
        )
        errors.append(found - sensor.clock_offset)
    return np.array(errors)


@dataclass(frozen=True, kw_only=True)
class ImuJob:
    """One program of a motion, run and evaluated: the arrays its figures and numbers need."""

    cfg: ImuExperimentCfg = field(default_factory=ImuExperimentCfg)
    program: int = 0
    """Which of the motion's programs."""
    individuals: int = 0
    """IMUs beside the run's own whose clocks are found on it."""
    seed: int = 0

    @property
    def cost(self) -> float:
        """Rough, relative: for the time left."""
        return 3.0 + 0.05 * self.individuals

    def run(self) -> dict[str, Any]:
        """Run it. K samples of the IMU, N of the log, M moves; SI units, base axes.

        Fields of `Comparison` and `Measures` and window_rms (K, 3); the same with `as_thesis_` and
        `best_` before, of those ways of processing. Log: log_time (N,), motor_angle (N, 6), tool,
        tool_predicted and imu_position (N, 3), gear (6,). Moves: move_start, move_end, move_speed
        (NaN: a share of the joints') and move_reached, (M,). clock_errors (individuals,). With a
        rectangle: fast_over_slow, and largest_in_rectangle (3,), where window_rms is largest.
        """
        done = run_one(self.cfg, prepare(self.cfg)[self.program], self.seed)
        recording = done.run.recording
        rngs = [np.random.default_rng([self.seed, i]) for i in range(self.individuals)]
        return (
            _evaluated(done)
            | self._otherwise("as_thesis_", AS_THE_THESIS, done)
            | self._otherwise("best_", BEST, done)
            | _moves(done.prepared.motion)
            | {
                "log_time": recording.time,
                "motor_angle": recording.motor_angle,
                "tool": done.evaluation.tool,
                "tool_predicted": done.evaluation.tool_predicted,
                "imu_position": imu_position(self.cfg, recording),
                "gear": done.prepared.loaded.model.drives.gear,
                "clock_errors": clock_errors(self.cfg, recording, rngs),
            }
        )

    def _otherwise(self, prefix: str, change: dict[str, Any], done: Done) -> dict[str, Array]:
        """The same run with some options of the processing changed."""
        again = _evaluated(processed_again(replace(self.cfg, **change), done))
        return {f"{prefix}{name}": value for name, value in again.items()}


def _evaluated(done: Done) -> dict[str, Array]:
    found = asdict(done.evaluation.comparison) | asdict(done.measures)
    found["window_rms"] = done.evaluation.window_rms
    if any(report.programmed.path == RECTANGLE for report in done.prepared.motion.reports):
        found["fast_over_slow"] = fast_over_slow(done)
        largest_at = done.measures.acceleration_window_time
        found["largest_in_rectangle"] = in_the_rectangle(done, largest_at)
    return {name: np.asarray(value) for name, value in found.items()}


def _moves(motion: JointMotion) -> dict[str, Array]:
    reports = motion.reports
    return {
        "move_start": np.array([report.start for report in reports]),
        "move_end": np.array([report.end for report in reports]),
        "move_speed": np.array([report.programmed.path or np.nan for report in reports]),
        "move_reached": np.array([report.reached for report in reports]),
    }


@dataclass(frozen=True, kw_only=True)
class RestJob:
    """The robot at rest, its motors off and then on."""

    cfg: ImuExperimentCfg = field(default_factory=lambda: ImuExperimentCfg(motion="rest"))
    seed: int = 0

    @property
    def cost(self) -> float:
        """Rough, relative, as that of `ImuJob`."""
        return 0.1 * (self.cfg.off + self.cfg.on)

    def run(self) -> dict[str, Any]:
        """Run it. Fields of `Rest`, and time (K,) [s], acceleration (K, 3) [m/s^2], IMU axes."""
        run, rest = run_rest(self.cfg, self.seed)
        signals = {"time": run.samples.time, "acceleration": run.samples.acceleration}
        return asdict(rest) | signals
