"""The same cut learned from each measured output: motor angles, estimate, tracker, ground truth."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from ..estimation.arm_springs import Springs
from ..estimation.tool_law import ToolLaw
from ..instruments.imu import ImuCfg
from .design import default_design
from .experiment import Experiment, Iteration, prepare
from .learning import first_run, iterate, learned
from .measures import MotorAngles
from .specification import Cut
from .tool_measure import Source, ToolOutput, ToolPath

COMPARED = ToolPath(law=ToolLaw(gamma=0.8))
"""Learning gain of the comparison and of the claims about estimation."""


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
        springs: Springs | None = None,
        repeats: int = 1,
    ) -> tuple[ToolOutput, Iterator[Iteration]]:
        """Learn from the tool's path; commissioned by the first run, or on known springs."""
        experiment = self.experiment()
        measure = replace(measure, imu=self.cut.imu or measure.imu, springs=springs)
        arm, first = measure.assumed(experiment), first_run(experiment)
        output = measure.commissioned(experiment, arm, first)
        return output, learned(experiment, output, first, iterations, repeats=repeats)

    def from_motors(self, iterations: int) -> Iterator[Iteration]:
        """Learn from the motor angles, as the thesis does, with the default design of the robot."""
        experiment = self.experiment()
        measure = MotorAngles(default_design(self.cut.cell))
        return iterate(experiment, measure.prepare(experiment), iterations)

    def compared(self, iterations: int, measure: ToolPath = COMPARED) -> dict[str, list[Iteration]]:
        """Iterations by measured output; one identification serves all laws."""
        output, estimated = self.from_tool(iterations, measure)
        found = {"motor": list(self.from_motors(iterations)), "estimate": list(estimated)}
        for source, name in ((Source.TRACKER, "tracker"), (Source.TRUTH, "oracle")):
            chosen = replace(measure, source=source)
            found[name] = list(self.from_tool(iterations, chosen, output.known.springs)[1])
        return found


def rms(iterations: list[Iteration]) -> list[float]:
    """Tool RMS (9.6) of each iteration, from tracker samples [m]."""
    return [iteration.tool.rms for iteration in iterations]
