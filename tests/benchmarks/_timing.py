"""Timing that survives a shared machine: interleaved rounds in one process, medians."""

import resource
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.sim.robot.run import LoadedReference


def peak_memory() -> float:
    """Largest memory of this process so far [GB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024e-9


def bare_rollout(loaded: LoadedReference) -> Callable[[], None]:
    """A function of the steps of a run and nothing else."""
    controls = loaded.controls_with(np.zeros_like(loaded.reference), None)[0][None]
    state, data = loaded.initial_state[None], [mujoco.MjData(loaded.model.mj)]

    def roll_out() -> None:
        with Rollout(nthread=0) as rollout:
            rollout.rollout([loaded.model.mj], data, state, controls)

    return roll_out


@dataclass(frozen=True)
class Row:
    """One line of a benchmark: our time, and the time of a peer for the same result."""

    name: str
    ours: float
    """[s] per call."""
    peer: str | None = None
    """Name of the peer; None when there is nothing to compare with, or it is not installed."""
    theirs: float | None = None
    """[s] per call, measured in turns with ours."""

    @property
    def ratio(self) -> float | None:
        """Our time divided by the peer's."""
        return None if self.theirs is None else self.ours / self.theirs


def interleaved(
    functions: Sequence[Callable[[], Any]], repeats: int = 9, min_round: float = 0.005
) -> list[float]:
    """Median seconds per call of each function, all of them called in turns.

    A function that is faster than `min_round` [s] is called several times in each of its turns.
    One turn of each comes first and does not count.
    """
    calls = [_calls_per_round(function, min_round) for function in functions]
    rounds = [list(map(_seconds, functions, calls)) for _ in range(repeats)]
    return [median(column) for column in zip(*rounds, strict=True)]


def timed(functions: Mapping[str, Callable[[], Any]], repeats: int = 9) -> list[Row]:
    """Rows of functions by name, called in turns."""
    return list(map(Row, functions, interleaved(list(functions.values()), repeats)))


def _seconds(function: Callable[[], Any], calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        function()
    return (time.perf_counter() - start) / calls


def _calls_per_round(function: Callable[[], Any], min_round: float) -> int:
    """Double the calls until a turn is long enough; this also warms the function up."""
    calls = 1
    while (elapsed := _seconds(function, calls) * calls) < min_round:
        calls *= 2 if elapsed < 0.1 * min_round else 1 + int(min_round / elapsed)
    return calls
