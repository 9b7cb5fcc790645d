"""The learning loop: repeat the task, look at the error, correct, repeat."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from armside.arrays import Array, shown

from .divergence import DIVERGENCE_RATIO, has_diverged
from .laws.first_order import Law
from .measures.norms import two_norm
from .plant import Plant
from .records import as_number, as_record, as_samples, as_whole

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class LoopState:
    """Everything that the trials after a trial depend on, the plant apart."""

    k: int
    correction: Array
    """u_k, shape (N, n)."""
    error: Array
    """e_k, shape (N, n)."""
    memory: Any
    """Of the law, before the update that follows the trial."""
    first_size: Array
    """(n,) sizes of the first error, by which divergence is judged."""

    def check(self, correction: tuple[int, ...], error: tuple[int, ...]) -> None:
        """Raise ValueError unless both are finite and of these shapes."""
        for name, needed in (("correction", correction), ("error", error)):
            given = as_record(getattr(self, name), f"the {name} to resume from")
            if given.shape != needed:
                shapes = f"the shape {needed}, got {given.shape}"
                raise ValueError(f"the {name} to resume from must have {shapes}")


@dataclass(frozen=True)
class Trial(Generic[Result]):
    """One repetition of the task: u_k, the measured y_k and e_k = r - y_k. Thesis (9.2).

    Arrays have shape (N, n) and are read-only.
    """

    k: int
    """Iteration; 0 is before any learning, unless the loop was given a first correction."""
    correction: Array
    output: Array
    error: Array
    result: Result
    """Whatever the plant returned."""
    diverged: bool = False
    """True for the last trial of a loop that had to stop."""
    memory: Any = None
    """Of the law, before the update that follows."""
    first_size: Array | None = None
    """(n,) sizes of the first error of the loop."""

    def __post_init__(self) -> None:
        for name in ("correction", "output", "error"):
            values = np.array(getattr(self, name))
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    @property
    def state(self) -> LoopState:
        """State from which `learn` goes on after this trial. ValueError if it has none."""
        if self.first_size is None:
            raise ValueError("this trial was not made by `learn`: it has no state to go on from")
        return LoopState(self.k, self.correction, self.error, self.memory, self.first_size)


def learn(
    plant: Plant[Result],
    law: Law,
    reference: Array,
    iterations: int,
    *,
    output_of: Callable[[Result], Any] = np.asarray,
    first_correction: Array | None = None,
    first_result: Result | None = None,
    resume: LoopState | None = None,
    size_of: Callable[[Array], Array] = two_norm,
    divergence_ratio: float = DIVERGENCE_RATIO,
    n_inputs: int | None = None,
) -> Iterator[Trial[Result]]:
    """Trials k = 0 .. iterations: that many updates, one run more.

    Args:
        reference: r, shape (N, n), the desired output.
        output_of: reads y, shape (N, n), from the plant's result.
        first_correction: u_0, zero if not given.
        first_result: of the run with u_0, where that has been made already.
        resume: state after an earlier trial k; the trials are then k + 1 .. k + iterations, the
            same as those of one loop if the plant is in the same state.
        size_of: sizes of an error (N, n) that `divergence_ratio` applies to; 2-norms of columns.
        divergence_ratio: see `has_diverged`.
        n_inputs: columns of a correction; as many as the reference has if None.

    The loop ends early, its last trial marked `diverged`, when an error is not finite or diverged.
    The plant is given a copy of each correction.

    Raises:
        ValueError: at once, for a reference, law or state that does not fit; at the first run, for
            an output of another shape than the reference, or not finite.
    """
    reference = as_record(reference, "reference")
    if as_whole(as_number(iterations, "iterations"), "iterations") < 0:
        raise ValueError(f"iterations must be >= 0, got {iterations}")
    if np.ndim(divergence_ratio) or not divergence_ratio > 0.0:
        raise ValueError(f"divergence_ratio must be > 0, got {shown(divergence_ratio)}")
    shape = len(reference), reference.shape[1] if n_inputs is None else n_inputs
    law.check(*shape)
    if resume is not None and (first_correction is not None or first_result is not None):
        raise ValueError("resume takes neither first_correction nor first_result")
    given = first_correction if resume is None else resume.correction
    name = "first_correction" if resume is None else "the correction to resume from"
    start = np.zeros(shape) if given is None else as_record(given, name)
    if start.shape != shape:
        of = " of the reference" if shape == reference.shape else ": one column for each input"
        needed = f"the shape {shape}{of}"
        raise ValueError(f"{name} must have {needed}, got {start.shape}")

    if resume is not None:
        resume.check(shape, reference.shape)

    def trials() -> Iterator[Trial[Result]]:
        correction, memory, first_size, first = start, None, None, 0
        if resume is not None:
            first, first_size = resume.k + 1, resume.first_size
            if iterations:
                correction, memory = law.step(correction, resume.error, resume.memory)
        last = iterations if resume is None else resume.k + iterations
        for k in range(first, last + 1):
            made = first_result if k == 0 else None
            result = plant.run(correction.copy()) if made is None else made
            # A plant may diverge by learning, to values that are not finite, but not before it.
            gate = as_samples if k > 0 else as_record
            output = gate(output_of(result), f"the output of run {k}")
            if output.shape != reference.shape:
                needed = f"the shape {reference.shape} of the reference"
                raise ValueError(f"the output must have {needed}, got {output.shape}")
            error = reference - output
            size = size_of(error)
            first_size = size if first_size is None else first_size
            diverged = not np.isfinite(error).all() or (
                k > 0 and has_diverged(size, first_size, divergence_ratio)
            )
            yield Trial(k, correction, output, error, result, diverged, memory, first_size)
            if diverged or k == last:
                return
            correction, memory = law.step(correction, error, memory)

    return trials()
