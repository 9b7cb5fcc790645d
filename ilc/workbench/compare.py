"""One learning experiment of a comparison: a task, a law, a noise level, a repetition."""

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from armside.arrays import Array

from ..learning import LoopState, Trial, learn
from ..records import as_real
from .laws import build_law
from .prediction import Prediction, predict
from .setting import Setting
from .state import RunState, states_of
from .task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class LawRun:
    """Result of one law. Lists have one entry a run."""

    law: str
    noise: float
    repetition: int
    first_k: int
    """Iteration of the first run: 0, or that after the one it continues."""
    norms: Array
    """(K,) 2-norm of e_k over samples and columns."""
    largest: Array
    """(K,) largest |e_k|."""
    measures: list[Mapping[str, float]] = field(repr=False)
    correction: Array = field(repr=False)
    """(N, n) of the last run."""
    diverged: bool
    state: RunState | None = field(repr=False)
    """None for a plant run by hand, whose folder is the state."""
    prediction: Prediction | None = None


@dataclass(frozen=True)
class _Measured:
    """Plant with white noise on its output."""

    plant: Any
    output_of: Callable[[Any], Any]
    noise: float
    rng: np.random.Generator

    def run(self, correction: Array, /) -> tuple[Any, Array]:
        result = self.plant.run(correction)
        output = as_real(self.output_of(result), "the output")
        if self.noise > 0.0:
            output = output + self.rng.normal(0.0, self.noise, output.shape)
        return result, output


def _predicted(
    law: str, setting: Setting, first: Trial[Any], earlier: LoopState | None, iterations: int
) -> Prediction:
    """Prediction from the first run, or from the last one of the experiment that is continued.

    Its errors are those of the runs from the first one here on.
    """
    if earlier is None:
        start = first.correction
        return predict(law, setting, first.error, iterations, first_correction=start)
    error, start, memory = earlier.error, earlier.correction, earlier.memory
    seen = predict(law, setting, error, iterations, first_correction=start, memory=memory)
    return replace(seen, errors=seen.errors[1:])


def setting_of(task: Task, experiment: Callable[[Array], Array] | None = None) -> Setting:
    """What laws for a task are built for."""
    return Setting(
        sample_time=task.sample_time,
        reference=task.reference,
        model=task.model,
        cutoff=task.default_cutoff,
        experiment=(lambda correction: correction) if experiment is None else experiment,
        design=task.design,
    )


def run_law(
    task: Task,
    law: str,
    iterations: int,
    *,
    seed: int = 0,
    noise: float = 0.0,
    repetition: int = 0,
    resume: RunState | None = None,
    start: Array | None = None,
    step: Callable[[], None] = lambda: None,
) -> LawRun:
    """Learn with the law that the words name.

    noise: standard deviation of white noise on the measured output, the same draws for all laws.
    resume: state after an earlier run, which is continued. start: u_0, (N, n). step: called after
    each run.

    Raises ValueError for what does not fit, OwnCodeError for what a user's code raises.
    """
    inner = task.start(repetition)
    rng = np.random.default_rng((seed, repetition, 1))
    generators = [rng, *task.generators_of(inner)]
    plant = _Measured(inner, task.output_of, noise, rng)
    setting = setting_of(task, lambda correction: plant.run(correction)[1])
    built = build_law(law, setting)
    if resume is not None:
        resume.restore(generators)
    loop = None if resume is None else resume.loop
    earlier = deepcopy(loop)  # own laws may change their memory in place
    first = last = None
    norms, largest, measures = list[float](), list[float](), list[Mapping[str, float]]()
    drawn = states_of(generators)
    for trial in learn(
        plant,
        built,
        task.reference,
        iterations,
        output_of=lambda made: made[1],
        first_correction=start,
        resume=loop,
    ):
        first = trial if first is None else first
        norms.append(float(np.linalg.norm(trial.error)))
        largest.append(float(np.abs(trial.error).max()))
        measures.append(task.measures_of(trial.result[0]))
        last, drawn = trial, states_of(generators)
        step()
    if first is None or last is None:
        raise ValueError("an experiment that is continued needs at least one more update")
    prediction = None
    if task.model is not None:
        prediction = _predicted(law, setting, first, earlier, iterations)
    return LawRun(
        law=law,
        noise=noise,
        repetition=repetition,
        first_k=first.k,
        norms=np.array(norms),
        largest=np.array(largest),
        measures=measures,
        correction=last.correction,
        diverged=last.diverged,
        state=RunState(loop=last.state, generators=drawn),
        prediction=prediction,
    )
