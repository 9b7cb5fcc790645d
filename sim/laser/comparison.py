"""The same cut learned from each measured output: motor angles, estimate, tracker, ground truth."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from ..estimation.elasticity import ArmParameters
from ..instruments.imu import ImuCfg
from .design import default_design
from .experiment import Experiment, Iteration, prepare
from .loop import Start, first_run, iterate
from .measures import MotorAngles
from .specification import Cut
from .tool_measure import Source, ToolOutput, ToolPath

COMPARED = ToolPath()
"""Measure of the comparison and of the claims about estimation: that of `armside laser`."""
COMPARED_OUTPUTS = ("motor", "estimate", "tracker", "oracle")
"""Measured outputs; each may have a start of its own in `compared`."""


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
        start: Start | None = None,
    ) -> tuple[ToolOutput, Iterator[Iteration]]:
        """Learn from the tool's path; commissioned by the first run, or on known parameters."""
        experiment = self.experiment()
        measure = replace(measure, imu=self.cut.imu or measure.imu, parameters=parameters)
        arm = measure.assumed(experiment)
        first = first_run(experiment, start=start)
        output = measure.commissioned(experiment, arm, first)
        return output, iterate(
            experiment, lambda _: output, iterations, start=start, first=first, repeats=repeats
        )

    def from_motors(self, iterations: int, *, start: Start | None = None) -> Iterator[Iteration]:
        """Learn from the motor angles, as the thesis does, with the default design of the robot."""
        experiment = self.experiment()
        set_up = MotorAngles(default_design(self.cut.cell)).prepare(experiment)
        return iterate(experiment, set_up, iterations, start=start)


def compared(
    case: Case,
    iterations: int,
    measure: ToolPath = COMPARED,
    starts: Mapping[str, Start] | None = None,
) -> dict[str, list[Iteration]]:
    """Learned from each of `COMPARED_OUTPUTS`; one identification, by the estimate's first run,
    serves all.

    starts: by output, for those that do not start without correction.

    Raises InputError where a loop to go on from is another one's.
    """
    known, parameters = starts or {}, None
    found = {"motor": list(case.from_motors(iterations, start=known.get("motor")))}
    # The sources of the enumeration are in the order of the outputs.
    for source, name in zip(Source, COMPARED_OUTPUTS[1:], strict=True):
        chosen = replace(measure, source=source)
        output, learning = case.from_tool(iterations, chosen, parameters, start=known.get(name))
        found[name] = list(learning)
        parameters = parameters or output.known.parameters
    return found


def rms(iterations: list[Iteration]) -> list[float]:
    """Tool RMS (9.6) of each iteration, from tracker samples [m]."""
    return [iteration.tool.rms for iteration in iterations]
