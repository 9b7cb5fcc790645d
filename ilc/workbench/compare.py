"""One learning experiment of a comparison, and its state on disk.

An experiment is a task, a law, a noise level and a repetition. Its state has the loop, the memory
of the law and the sources of noise, in one .npz file without pickled objects. A memory may be
None, a number, text, an array, and tuples, lists and dicts of these; named tuples of our laws
come back as themselves.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array, npz

from ..laws.knob_free import Known
from ..laws.wrappers import Best, SegmentMemory
from ..learning import LoopState, Trial, learn
from ..records import as_number, as_real, as_record, as_samples
from .laws import build_law
from .predicted import Prediction, predict
from .task import Setting, Task

NAMED: Mapping[str, Callable[..., Any]] = {
    "Best": Best,
    "Known": Known,
    "SegmentMemory": SegmentMemory,
}
"""Named tuples that a memory may hold."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunState:
    """State after the last run of one law."""

    loop: LoopState
    generators: Sequence[Mapping[str, Any]] = ()
    """States of the bit generators of all noise, in a fixed order."""
    start: Array | None = None
    """u_0, (N, n), that the law learns around; None for a loop from zero."""

    def restore(self, generators: Sequence[np.random.Generator]) -> None:
        """Set sources of noise to the stored states. ValueError if they are others."""
        if len(generators) != len(self.generators):
            counts = f"{len(self.generators)} sources of noise, this one has {len(generators)}"
            raise ValueError(f"the stored run had {counts}")
        for generator, state in zip(generators, self.generators, strict=True):
            generator.bit_generator.state = state


def states_of(generators: Sequence[np.random.Generator]) -> tuple[Mapping[str, Any], ...]:
    """States of bit generators, to be stored."""
    return tuple(dict(generator.bit_generator.state) for generator in generators)


def save_states(file: Path, states: Mapping[str, RunState]) -> list[str]:
    """Write states by key; the keys of those that cannot be stored, for their law's memory."""
    arrays: dict[str, Any] = {}
    trees: dict[str, Any] = {}
    unstored: list[str] = []
    for key, state in states.items():
        loop = state.loop
        content = {
            "k": loop.k,
            "correction": loop.correction,
            "error": loop.error,
            "memory": loop.memory,
            "first_size": loop.first_size,
            "generators": [dict(each) for each in state.generators],
            "start": state.start,
        }
        try:
            trees[key] = _packed(content, arrays)
        except TypeError:
            unstored.append(key)
            trees[key] = _packed(content | {"memory": None, "unstored": True}, arrays)
    with file.open("wb") as stream:
        np.savez(stream, tree=np.array(json.dumps(trees)), **arrays)  # type: ignore[arg-type]
    return unstored


def read_states(file: Path) -> dict[str, RunState | None]:
    """States by key; None where a memory could not be stored. ValueError for a damaged file."""
    try:
        with npz(file) as stored:
            trees = json.loads(str(stored["tree"]))
            contents = {key: _unpacked(tree, stored) for key, tree in trees.items()}
            return {key: _state(content) for key, content in contents.items()}
    except Exception as error:  # numpy, zipfile and json raise many kinds
        reason = str(error).removeprefix(f"{file} ")
        raise ValueError(f"{file} holds no state of a learning run: {reason}") from error


def _state(content: dict[str, Any]) -> RunState | None:
    if content.get("unstored"):
        return None
    k, start = content["k"], content.get("start")
    if not (isinstance(k, int) and k >= 0):
        raise ValueError(f"k must be a whole number >= 0, got {k!r}")
    loop = LoopState(
        k=k,
        correction=as_record(content["correction"], "correction"),
        error=as_samples(content["error"], "error"),
        memory=content["memory"],
        first_size=as_real(content["first_size"], "first_size"),
    )
    if loop.first_size.ndim != 1:
        raise ValueError(f"first_size must have shape (m,), got {loop.first_size.shape}")
    if start is not None and (start := as_record(start, "start")).shape != loop.correction.shape:
        raise ValueError(f"start must have the shape {loop.correction.shape}, got {start.shape}")
    return RunState(loop=loop, generators=tuple(content["generators"]), start=start)


def _packed(value: Any, arrays: dict[str, Any]) -> Any:
    if value is None or isinstance(value, (bool, int, float, str)):
        return {"plain": value}
    if isinstance(value, (np.ndarray, np.generic)):
        array = np.asarray(value)
        if array.dtype.kind not in "biufcU":
            raise TypeError(f"an array of {array.dtype}")
        name = f"array_{len(arrays)}"
        arrays[name] = array
        return {"array": name}
    if isinstance(value, Mapping):
        return {"dict": [[_packed(k, arrays), _packed(v, arrays)] for k, v in value.items()]}
    if isinstance(value, (tuple, list)):
        kind = type(value).__name__
        if kind not in ("tuple", "list", *NAMED):
            raise TypeError(f"a {kind}")
        return {"items": [_packed(item, arrays) for item in value], "kind": kind}
    raise TypeError(f"a {type(value).__name__}")


def _unpacked(tree: Any, arrays: Any) -> Any:
    if "plain" in tree:
        return tree["plain"]
    if "array" in tree:
        return arrays[tree["array"]]
    if "dict" in tree:
        return {_unpacked(k, arrays): _unpacked(v, arrays) for k, v in tree["dict"]}
    items = [_unpacked(item, arrays) for item in tree["items"]]
    if tree["kind"] in NAMED:
        return NAMED[tree["kind"]](*items)
    return tuple(items) if tree["kind"] == "tuple" else items


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
    if as_number(noise, "noise") < 0.0:
        raise ValueError(f"noise must be >= 0, got {noise}")
    as_number(iterations, "iterations")
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
