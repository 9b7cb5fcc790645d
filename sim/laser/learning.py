"""The learning loop of a cut: run, measure, correct, run again."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array
from armside.ilc import learning
from armside.ilc.divergence import DIVERGENCE_RATIO
from armside.ilc.laws import Law, Simulated
from armside.ilc.laws.around import Around
from armside.ilc.laws.guarded import Guarded
from armside.ilc.plant import Plant
from armside.ilc.workbench.state import RunState

from ..notes import Cause, Note
from .experiment import Experiment, Iteration, evaluated, prepare
from .measures import Measure, MotorAngles, Noted, Output, SetUp
from .plant import Pass
from .resume import first_trial, restore
from .specification import Cut
from .tool_measure import Source, ToolPath

FROM_A_MODEL = 10.0
"""Factor on the ratio that counts as divergence where learning starts from a model's correction:
its first error is a tenth of the usual one."""
MEASURES: Mapping[str, Measure] = {
    "motor": MotorAngles(),
    **{source.value: ToolPath(source=source) for source in Source},
}
"""By name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Begin:
    """Beginning of a loop: without correction, with one, or where an earlier loop ended."""

    start: Array | None = None
    """(N, n) [rad], correction of the first run."""
    resume: RunState | None = None
    """State after an earlier run, which has a first correction of its own."""

    @property
    def first_correction(self) -> Array | None:
        """Correction of k = 0; None for none."""
        return self.start if self.resume is None else self.resume.start


def learn(
    cut: Cut,
    *,
    measure: str | Measure = "motor",
    law: Law | None = None,
    iterations: int = 5,
    seed: int = 0,
    plant: Plant[Pass] | None = None,
    start: Array | None = None,
) -> Iterator[Iteration]:
    """Iterations k = 0 .. `iterations` of a cut, until done or diverged.

    Args:
        measure: output that is learned from: motor, estimate, tracker, truth, or one's own.
        law: learning law for errors of that output; the measure's default if None.
        seed: of the instruments' set-up and all noise, and of friction where the cut has no
            individual.
        plant: runs corrections in place of the virtual robot.
        start: (N, n) [rad], correction of the first run, such as a twin's; zero if None.

    Raises:
        ValueError: at once, for a cut that cannot be made, an unknown name, or a robot that the
            measure cannot serve.
        ImuError: at the first run, for an IMU that cannot be used.
    """
    if isinstance(measure, str) and measure not in MEASURES:
        raise ValueError(f"Unknown measure {measure!r}. Measures: {', '.join(MEASURES)}")
    chosen = MEASURES[measure] if isinstance(measure, str) else measure
    experiment = prepare(replace(cut, imu=cut.imu or chosen.imu), seed=seed)
    set_up = chosen.prepare(experiment)
    return iterate(experiment, set_up, iterations, law=law, plant=plant, start=start)


def iterate(
    experiment: Experiment,
    set_up: SetUp,
    iterations: int,
    *,
    law: Law | None = None,
    plant: Plant[Pass] | None = None,
    start: Array | None = None,
    resume: RunState | None = None,
) -> Iterator[Iteration]:
    """As `learn`, for a prepared experiment and measure: `measure.prepare`.

    resume: state after an earlier run, which is gone on from; see `trials`.
    """
    start = start if resume is None else resume.start
    first = first_run(experiment, plant, start)
    output = set_up(first)
    about = {"law": law, "plant": plant, "start": start, "resume": resume}
    yield from learned(experiment, output, first, iterations, **about)


def first_run(
    experiment: Experiment, plant: Plant[Pass] | None = None, start: Array | None = None
) -> Pass:
    """The run of k = 0, without correction or with that to start from."""
    plant = experiment.plant if plant is None else plant
    return plant.run(np.zeros_like(experiment.loaded.reference) if start is None else start)


def learned(
    experiment: Experiment,
    output: Output,
    first: Pass,
    iterations: int,
    *,
    law: Law | None = None,
    plant: Plant[Pass] | None = None,
    repeats: int = 1,
    start: Array | None = None,
    resume: RunState | None = None,
) -> Iterator[Iteration]:
    """As `learn`, from an output that was set up by the first run.

    repeats: runs that are averaged in each iteration.
    """
    used = experiment.plant if plant is None else plant
    more = [first_run(experiment, plant, start) for _ in range(repeats - 1)]
    found = trials(used, output, [first, *more], iterations, law=law, start=start, resume=resume)
    for trial, notes in found:
        yield evaluated(experiment, trial, trial.result[0], notes)


def trials(
    plant: Plant[Pass],
    output: Output,
    first: list[Pass],
    iterations: int,
    *,
    law: Law | None = None,
    start: Array | None = None,
    resume: RunState | None = None,
) -> Iterator[tuple[learning.Trial[list[Pass]], tuple[Note, ...]]]:
    """Trials k = 0 .. `iterations` with notes of the loop, from the runs of k = 0.

    Args:
        first: runs of k = 0; as many are averaged in each iteration.
        resume: state after trial K of an earlier loop: the trials are then 0, which is that of
            `first`, and K + 1 .. K + iterations, the same as those of one loop.

    Raises InputError where `first` is not the first run of the loop that is resumed.
    """
    law = output.law if law is None else law
    # A law on a simulated plant is given the whole correction, as its plant is.
    law = law if start is None or isinstance(law, Simulated) else Around(law, start)
    loop = None if resume is None else resume.loop
    if resume is not None:
        yield first_trial(output, first, resume), ()
        restore(plant, resume)
    found = learning.learn(
        _Repeated(plant, len(first)),
        law,
        output.reference,
        iterations,
        output_of=lambda runs: np.mean([output(run) for run in runs], axis=0),
        first_correction=None if loop else start,
        first_result=None if loop else first,
        resume=loop,
        size_of=output.size,
        n_inputs=first[0].recording.n_axes,
        divergence_ratio=DIVERGENCE_RATIO * (1.0 if start is None else FROM_A_MODEL),
    )
    smallest = np.inf
    if loop is not None and isinstance(law, Guarded):
        smallest = min(np.inf if loop.memory is None else loop.memory.size, law.size(loop.error))
    for trial in found:
        notes = output.notes if isinstance(output, Noted) else ()
        if isinstance(law, Guarded):
            size = law.size(trial.error)
            if size > law.tolerance * smallest:
                notes = (*notes, _BACK)
            smallest = min(size, smallest)
        yield trial, notes


_BACK = Note(
    cause=Cause.GUARD, text="the error had grown: learning went back to its best iteration"
)


@dataclass(frozen=True)
class _Repeated:
    plant: Plant[Pass]
    times: int

    def run(self, correction: Array, /) -> list[Pass]:
        return [self.plant.run(correction) for _ in range(self.times)]
