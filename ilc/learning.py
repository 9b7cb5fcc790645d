"""The learning loop: repeat the task, look at the error, correct, repeat."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from armside.arrays import Array

from .laws.law import Law
from .measures.norms import two_norm
from .plant import Plant, as_record

Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class Trial(Generic[Result]):
    """One repetition of the task. Arrays have shape (N, n) and are read-only."""

    k: int
    """Iteration; 0 is before any learning, unless the loop was given a first correction."""
    correction: Array
    """u_k."""
    output: Array
    """y_k, as measured."""
    error: Array
    """e_k = r - y_k. Thesis (9.2)."""
    result: Result
    """Whatever the plant returned."""
    diverged: bool = False
    """True for the last trial of a loop that had to stop."""

    def __post_init__(self) -> None:
        for name in ("correction", "output", "error"):
            values = np.array(getattr(self, name))
            values.setflags(write=False)
            object.__setattr__(self, name, values)


def learn(
    plant: Plant[Result],
    law: Law,
    reference: Array,
    iterations: int,
    *,
    output_of: Callable[[Result], Any] = np.asarray,
    first_correction: Array | None = None,
    divergence_ratio: float = 3.0,
) -> Iterator[Trial[Result]]:
    """Yield trials k = 0 .. iterations: that many updates, one run more.

    reference: r, shape (N, n), what the output should be. output_of: reads y, shape (N, n), from
    what the plant returns. first_correction: u_0, zero if not given.

    The loop ends early, its last trial marked `diverged`, when an error is not finite or when
    the 2-norm of a column exceeds divergence_ratio times its value at k = 0 (infinity: never).

    Raises:
        ValueError: at once, for a reference or law that does not fit; at the first run, for an
            output of another shape than the reference.
    """
    reference = as_record(reference, "reference")
    if iterations < 0:
        raise ValueError(f"iterations must be >= 0, got {iterations}")
    if not divergence_ratio > 0.0:
        raise ValueError(f"divergence_ratio must be > 0, got {divergence_ratio}")
    law.check(*reference.shape)
    if first_correction is None:
        first_correction = np.zeros_like(reference)
    first_correction = as_record(first_correction, "first_correction")
    if first_correction.shape != reference.shape:
        raise ValueError(
            f"first_correction must have the shape {reference.shape} of the reference, "
            f"got {first_correction.shape}"
        )
    return _trials(plant, law, reference, iterations, output_of, first_correction, divergence_ratio)


def _trials(
    plant: Plant[Result],
    law: Law,
    reference: Array,
    iterations: int,
    output_of: Callable[[Result], Any],
    correction: Array,
    divergence_ratio: float,
) -> Iterator[Trial[Result]]:
    memory = None
    limit = np.full(reference.shape[1], np.inf)
    for k in range(iterations + 1):
        result = plant.run(correction)
        output = np.asarray(output_of(result), dtype=np.float64)
        if output.shape != reference.shape:
            raise ValueError(
                f"the output must have the shape {reference.shape} of the reference, "
                f"got {output.shape}"
            )
        error = reference - output
        norm = two_norm(error)
        diverged = not np.isfinite(error).all() or bool((norm > limit).any())
        yield Trial(
            k=k, correction=correction, output=output, error=error, result=result, diverged=diverged
        )
        if diverged or k == iterations:
            return
        if k == 0 and np.isfinite(divergence_ratio):
            limit = divergence_ratio * norm
        correction, memory = law.step(correction, error, memory)
