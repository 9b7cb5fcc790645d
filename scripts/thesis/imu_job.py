"""Jobs of the IMU experiment: arrays that a report's figures and numbers need."""

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.sim.imu import ImuExperiment, ImuResult, RestExperiment
from armside.sim.imu.imu_experiment import clock_errors, prepare, reprocessed, run_one
from armside.sim.imu.phases import RECTANGLE
from armside.sim.imu.vibration import run_rest


@dataclass(frozen=True, kw_only=True)
class ImuJob:
    """One program of an experiment, run and evaluated."""

    experiment: ImuExperiment = field(default_factory=ImuExperiment)
    program: int = 0
    """Index among the motion's programs."""
    individuals: int = 0
    """Number of other IMUs whose clocks are synchronised on the same run."""
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
        (NaN: a fraction of the joints') and move_reached, (M,). clock_errors (individuals,). With a
        rectangle: fast_over_slow, and largest_in_rectangle (3,), where window_rms is largest.
        """
        result = run_one(self.experiment, prepare(self.experiment)[self.program], self.seed)
        recording, cfg = result.run.recording, self.experiment.processing
        rngs = [np.random.default_rng([self.seed, i]) for i in range(self.individuals)]
        found = _evaluated(result)
        for prefix, processing in (("as_thesis_", cfg.as_in_the_thesis), ("best_", cfg.best)):
            again = _evaluated(reprocessed(result, processing))
            found |= {f"{prefix}{name}": value for name, value in again.items()}
        reports = result.planned.motion.reports
        rows = [(r.start, r.end, r.programmed.path or np.nan, r.reached) for r in reports]
        names = ("move_start", "move_end", "move_speed", "move_reached")
        found |= dict(zip(names, np.array(rows).T, strict=True))
        return found | {
            "log_time": recording.time,
            "motor_angle": recording.motor_angle,
            "tool": result.evaluation.tool,
            "tool_predicted": result.evaluation.tool_predicted,
            "imu_position": result.imu_position,
            "gear": result.planned.loaded.model.drives.gear,
            "clock_errors": clock_errors(result, rngs),
        }


def _evaluated(result: ImuResult) -> dict[str, Array]:
    found = asdict(result.evaluation.comparison) | asdict(result.measures)
    found["window_rms"] = result.evaluation.window_rms
    if any(report.programmed.path == RECTANGLE for report in result.planned.motion.reports):
        found["fast_over_slow"] = result.fast_over_slow
        found["largest_in_rectangle"] = result.largest_in_rectangle
    return {name: np.asarray(value) for name, value in found.items()}


@dataclass(frozen=True, kw_only=True)
class RestJob:
    """Robot at rest, its motors off and then on."""

    experiment: RestExperiment = field(default_factory=RestExperiment)
    seed: int = 0

    @property
    def cost(self) -> float:
        """Rough, relative, as that of `ImuJob`."""
        return 0.1 * (self.experiment.off + self.experiment.on)

    def run(self) -> dict[str, Any]:
        """Run it. Fields of `Rest`, and time (K,) [s], acceleration (K, 3) [m/s^2], IMU axes."""
        result = run_rest(self.experiment, self.seed)
        samples = result.run.samples
        return asdict(result.rest) | {"time": samples.time, "acceleration": samples.acceleration}
