"""The learning loop of a cut: run, measure, correct, run again."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.divergence import DIVERGENCE_RATIO, has_diverged
from armside.ilc.laws import Law, Simulated
from armside.ilc.laws.wrappers import Around, BySegment, Guarded, SegmentMemory
from armside.ilc.learning import LoopState
from armside.ilc.plant import Plant
from armside.ilc.records import as_record, as_samples
from armside.ilc.workbench.compare import RunState, states_of

from ..evaluation.motion_error import motion_error
from ..notes import Cause, Note
from ..records.files import InputError
from .experiment import CuttingPlant, Experiment, Iteration, Pass, prepare
from .measures import Measure, MotorAngles, Noted, Output, SetUp
from .specification import Setup

FROM_A_MODEL = 10.0
"""Factor on the ratio that counts as divergence where learning starts from a model's correction:
its first error is a tenth of the usual one."""
MEASURES = ("motor", "estimate", "tracker", "scan", "truth")
"""Names of measured outputs."""
Start = Array | RunState
"""What learning starts from: (N, n) [rad], arm side, correction of the first run, such as a twin's;
or the state after an earlier run, which is gone on from."""


def learn(
    cut: Setup,
    *,
    measure: str | Measure = "motor",
    law: Law | None = None,
    iterations: int = 5,
    seed: int = 0,
    plant: Plant[Pass] | None = None,
    start: Start | None = None,
) -> Iterator[Iteration]:
    """Iterations k = 0 .. `iterations` of a cut, until done or diverged.

    Args:
        cut: of one contour, or of a part with many.
        measure: output that is learned from: motor, estimate, tracker, scan, truth, or one's own.
        seed: of the instruments' set-up and all noise, and of friction where the cut has no
            individual.
        law, plant, start: as of `iterate`.

    Raises:
        ValueError: at once, for a cut that cannot be made, an unknown name, or a robot that the
            measure cannot serve.
        ImuError: at the first run, for an IMU that cannot be used.
    """
    chosen = measure_of(measure) if isinstance(measure, str) else measure
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
    start: Start | None = None,
    first: Pass | None = None,
    repeats: int = 1,
    converged: float | None = None,
    inputs: int | None = None,
) -> Iterator[Iteration]:
    """The loop of `learn`, for an experiment and a measure that are prepared.

    Args:
        set_up: of the measure: `measure.prepare(experiment)`.
        law: learning law for errors of that output; the measure's default if None.
        plant: runs corrections in place of the virtual robot.
        start: correction of the first run; zero if None. From a state after run K of an earlier
            loop the iterations are 0, which is made again, and K + 1 .. K + `iterations`, the same
            as those of one loop.
        first: run of k = 0, where it is made already.
        repeats: runs that are averaged in each iteration.
        converged: a contour whose learned error falls by less than this fraction in two updates
            running keeps its best correction, and learning ends when all do; None for none.
        inputs: columns of a correction; as many as the robot has axes if None.

    Raises InputError where the first run is not that of the loop that is gone on from.
    """
    if iterations < 0:
        raise ValueError(f"iterations must be >= 0, got {iterations}")
    cut, motion, loaded = experiment.cut, experiment.motion, experiment.loaded
    plant = experiment.plant if plant is None else plant
    before, begun = (start, start.start) if isinstance(start, RunState) else (None, start)
    u = _as_correction(begun, loaded.reference, inputs)
    runs = [plant.run(u.copy()) if first is None else first]
    output = set_up(runs[0])
    reference = as_record(output.reference, "reference")
    runs += [plant.run(u.copy()) for _ in range(repeats - 1)]
    law = loop_law(output.law if law is None else law, output, experiment, begun, converged)
    law.check(len(reference), u.shape[1])
    ratio = DIVERGENCE_RATIO * (1.0 if begun is None else FROM_A_MODEL)
    k, last, memory, first_size = 0, iterations, None, None
    while True:
        error = reference - _mean([output(run) for run in runs], reference)
        size = output.size(error)
        first_size = size if first_size is None else first_size
        grown = k > 0 and has_diverged(size, first_size, ratio)
        run, held = runs[0], (False,) * len(cut.contours(motion))
        if isinstance(memory, SegmentMemory):
            held = tuple(map(bool, memory.held))
        tracked, true = cut.errors(motion, *run.tracked), cut.errors(motion, *run.true)
        iteration = Iteration(
            k=k,
            correction=u,
            error=error,
            run=run,
            motor_error=run.recording.error * loaded.model.drives.gear,
            tool=cut.whole(motion, tracked),
            tool_true=cut.whole(motion, true),
            contours=tracked,
            contours_true=true,
            measured_motion=partial(
                motion_error,
                motion,
                run.recording.truth,
                loaded.model.mj,
                free_rotation=cut.cell.free_rotation,
            ),
            diverged=grown or not bool(np.isfinite(error).all()),
            converged=held,
            notes=_notes(output, law, error, memory),
            state=RunState(
                loop=LoopState(k, u, error, memory, first_size),
                generators=states_of(generators(plant)),
                start=begun,
            ),
        )
        yield iteration
        if iteration.diverged or k == last or all(held):
            return
        if before is not None and k == 0:
            before.restore(_same_loop(size, before.loop, plant, u.shape, reference.shape))
            u, error, memory = before.loop.correction, before.loop.error, before.loop.memory
            k, last = before.loop.k, before.loop.k + iterations
        u, memory = law.step(u, error, memory)
        k += 1
        runs = [plant.run(u.copy()) for _ in range(repeats)]


def measure_of(name: str) -> Measure:
    """Measured output by its name. Raises ValueError for an unknown one."""
    if name not in MEASURES:
        raise ValueError(f"Unknown measure {name!r}. Measures: {', '.join(MEASURES)}")
    if name == "motor":
        return MotorAngles()
    if name == "scan":
        from .scan_measure import ScannedPart

        return ScannedPart()
    from .tool_measure import Source, ToolPath

    return ToolPath(source=Source(name))


def first_run(experiment: Experiment, start: Start | None = None) -> Pass:
    """The run of k = 0, without correction or with that to start from."""
    begun = start.start if isinstance(start, RunState) else start
    return experiment.plant.run(_as_correction(begun, experiment.loaded.reference))


def generators(plant: Any) -> list[np.random.Generator]:
    """Sources of noise of a plant, in a fixed order; none of one's own plant."""
    if not isinstance(plant, CuttingPlant):
        return []
    return [plant.rng, *([] if plant.imu is None else [plant.imu.rng])]


def _as_correction(start: Array | None, reference: Array, inputs: int | None = None) -> Array:
    shape = (len(reference), inputs or reference.shape[1])
    if start is None:
        return np.zeros(shape)
    found = as_record(start, "start")
    if found.shape != shape:
        needed = f"the shape {shape} of the reference"
        raise ValueError(f"start must have {needed}, got {found.shape}")
    return found


def loop_law(
    law: Law,
    output: Output,
    experiment: Experiment,
    start: Array | None = None,
    converged: float | None = None,
) -> Law:
    """The law, for each contour until it has converged, and around a first correction."""
    if converged is not None:
        cut, motion = experiment.cut, experiment.motion
        ends = [(contour.begin, contour.end) for contour in cut.contours(motion)]
        law = BySegment(
            law=law,
            weight=cut.weights(motion),
            judged=tuple(map(tuple, np.searchsorted(motion.time, ends).tolist())),
            size_of=output.size,
            least=converged,
        )
    # A law on a simulated plant is given the whole correction, as its plant is.
    inner = law.law if isinstance(law, Guarded) else law
    return law if start is None or isinstance(inner, Simulated) else Around(law, start)


def _mean(outputs: list[Array], reference: Array) -> Array:
    """(N, m), mean of outputs. Raises ValueError where it is not like the reference."""
    found = as_samples(np.mean(outputs, axis=0), "the output")
    if found.shape != reference.shape:
        needed = f"the shape {reference.shape} of the reference"
        raise ValueError(f"the output must have {needed}, got {found.shape}")
    return found


def _notes(output: Output, law: Law, error: Array, memory: Any) -> tuple[Note, ...]:
    found = output.notes if isinstance(output, Noted) else ()
    if memory is None or not isinstance(law, Guarded):
        return found
    back = "the error had grown: learning went back to its best iteration"
    grown = law.size(error) > law.tolerance * memory.size
    return (*found, Note(cause=Cause.GUARD, text=back)) if grown else found


def _same_loop(
    size: Array,
    loop: LoopState,
    plant: Any,
    correction: tuple[int, ...],
    error: tuple[int, ...],
) -> list[np.random.Generator]:
    """Sources of noise of a plant whose first run is that of a loop, by the size of its error.

    Raises InputError where it does not come out as it did.
    """
    try:
        loop.check(correction, error)
    except ValueError as wrong:
        raise InputError(f"it cannot be gone on from: {wrong}") from wrong
    if not np.array_equal(size, loop.first_size):
        other = "by another version, on another machine, or from files that have changed since"
        raise InputError(
            f"it cannot be gone on from: its first run does not come out the same here, {other}; "
            "with another --seed its correction is taken over"
        )
    return generators(plant)
