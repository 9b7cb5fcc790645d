"""The learning loop of a cut: run, measure, correct, run again."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array
from armside.ilc import learning
from armside.ilc.laws import Law
from armside.ilc.laws.guarded import Guarded
from armside.ilc.plant import Plant

from ..notes import Cause, Note
from .experiment import Experiment, Iteration, evaluated, prepare
from .measures import Measure, MotorAngles, Noted, Output, SetUp
from .plant import Pass
from .specification import Cut
from .tool_measure import Source, ToolPath

MEASURES: Mapping[str, Measure] = {
    "motor": MotorAngles(),
    **{source.value: ToolPath(source=source) for source in Source},
}
"""By name."""


def learn(
    cut: Cut,
    *,
    measure: str | Measure = "motor",
    law: Law | None = None,
    iterations: int = 5,
    seed: int = 0,
    plant: Plant[Pass] | None = None,
) -> Iterator[Iteration]:
    """Iterations k = 0 .. `iterations` of a cut, until done or diverged.

    Args:
        measure: output that is learned from: motor, estimate, tracker, truth, or one's own.
        law: learning law for errors of that output; the measure's default if None.
        seed: of the robot individual, of the instruments' set-up and of all noise.
        plant: runs corrections in place of the virtual robot.

    Raises:
        ValueError: at once, for a cut that cannot be made, an unknown name, or a robot that the
            measure cannot serve.
        ImuError: at the first run, for an IMU that cannot be used.
    """
    if isinstance(measure, str) and measure not in MEASURES:
        raise ValueError(f"Unknown measure {measure!r}. Measures: {', '.join(MEASURES)}")
    chosen = MEASURES[measure] if isinstance(measure, str) else measure
    experiment = prepare(replace(cut, imu=cut.imu or chosen.imu), seed=seed)
    return iterate(experiment, chosen.prepare(experiment), iterations, law=law, plant=plant)


def iterate(
    experiment: Experiment,
    set_up: SetUp,
    iterations: int,
    *,
    law: Law | None = None,
    plant: Plant[Pass] | None = None,
) -> Iterator[Iteration]:
    """As `learn`, for a prepared experiment and measure: `measure.prepare`."""
    first = first_run(experiment, plant)
    yield from learned(experiment, set_up(first), first, iterations, law=law, plant=plant)


def first_run(experiment: Experiment, plant: Plant[Pass] | None = None) -> Pass:
    """The run without correction, k = 0."""
    plant = experiment.plant if plant is None else plant
    return plant.run(np.zeros_like(experiment.loaded.reference))


def learned(
    experiment: Experiment,
    output: Output,
    first: Pass,
    iterations: int,
    *,
    law: Law | None = None,
    plant: Plant[Pass] | None = None,
    repeats: int = 1,
) -> Iterator[Iteration]:
    """As `learn`, from an output that was set up by the first run.

    repeats: runs that are averaged in each iteration.
    """
    more = [first_run(experiment, plant) for _ in range(repeats - 1)]
    law = output.law if law is None else law
    trials = learning.learn(
        _Repeated(experiment.plant if plant is None else plant, repeats),
        law,
        output.reference,
        iterations,
        output_of=lambda runs: np.mean([output(run) for run in runs], axis=0),
        first_result=[first, *more],
        size_of=output.size,
    )
    smallest = np.inf
    for trial in trials:
        found = output.notes if isinstance(output, Noted) else ()
        if isinstance(law, Guarded):
            size = law.size(trial.error)
            if size > law.tolerance * smallest:
                found = (*found, _BACK)
            smallest = min(size, smallest)
        yield evaluated(experiment, trial, trial.result[0], found)


_BACK = Note(
    cause=Cause.GUARD, text="the error had grown: learning went back to its best iteration"
)


@dataclass(frozen=True)
class _Repeated:
    plant: Plant[Pass]
    times: int

    def run(self, correction: Array, /) -> list[Pass]:
        return [self.plant.run(correction) for _ in range(self.times)]
