"""The same cut learned from each measured output: motor angles, estimate, tracker, ground truth."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from ..estimation.elasticity import ArmParameters
from ..instruments.imu import ImuCfg
from .design import default_design
from .experiment import Experiment, Iteration, prepare
from .learning import Begin, first_run, iterate, learned
from .measures import MotorAngles
from .specification import Cut
from .tool_measure import ToolOutput, ToolPath

COMPARED = ToolPath()
"""Measure of the comparison and of the claims about estimation: that of `armside laser`."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One cut with a seed, learned from any of the outputs."""

    cut: Cut = field(default_factory=lambda: Cut(imu=ImuCfg()))
    seed: int = 0

    def experiment(self) -> Experiment:
        """The individual at its place, with an IMU and under a tracker."""
        return prepare(self.cut, seed=self.seed)

    def from_tool(
        self,
        iterations: int,
        measure: ToolPath = COMPARED,
        parameters: ArmParameters | None = None,
        repeats: int = 1,
        *,
        experiment: Experiment | None = None,
        begin: Begin = Begin(),
    ) -> tuple[ToolOutput, Iterator[Iteration]]:
        """Learn from the tool's path; commissioned by the first run, or on known parameters.

        experiment: as `experiment()` makes one, in its place.
        """
        experiment = self.experiment() if experiment is None else experiment
        measure = replace(measure, imu=self.cut.imu or measure.imu, parameters=parameters)
        arm, start = measure.assumed(experiment), begin.first_correction
        first = first_run(experiment, start=start)
        output = measure.commissioned(experiment, arm, first)
        how = {"repeats": repeats, "start": start, "resume": begin.resume}
        return output, learned(experiment, output, first, iterations, **how)

    def from_motors(
        self,
        iterations: int,
        *,
        experiment: Experiment | None = None,
        begin: Begin = Begin(),
    ) -> Iterator[Iteration]:
        """Learn from the motor angles, as the thesis does, with the default design of the robot."""
        experiment = self.experiment() if experiment is None else experiment
        set_up = MotorAngles(default_design(self.cut.cell)).prepare(experiment)
        how = {"start": begin.start, "resume": begin.resume}
        return iterate(experiment, set_up, iterations, **how)


def rms(iterations: list[Iteration]) -> list[float]:
    """Tool RMS (9.6) of each iteration, from tracker samples [m]."""
    return [iteration.tool.rms for iteration in iterations]
