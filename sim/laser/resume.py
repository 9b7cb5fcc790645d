"""A learning loop that was stored, as the next one goes on from it: first run, noise and state."""

from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.learning import LoopState, Trial
from armside.ilc.workbench.compare import RunState, states_of

from ..records.files import InputError
from .measures import Output
from .plant import CuttingPlant, Pass


def generators(plant: Any) -> list[np.random.Generator]:
    """Sources of noise of a plant, in a fixed order; none of one's own plant."""
    if not isinstance(plant, CuttingPlant):
        return []
    return [plant.rng, *([] if plant.imu is None else [plant.imu.rng])]


def state_after(loop: LoopState, plant: Any, start: Array | None) -> RunState:
    """State from which a loop goes on after its last run, before the plant runs again.

    start: (N, n) [rad], correction of its first run; None for zero.
    """
    return RunState(loop=loop, generators=states_of(generators(plant)), start=start)


def restore(plant: Any, state: RunState) -> None:
    """Set the sources of noise of a plant to those of a state."""
    state.restore(generators(plant))


def first_trial(output: Output, first: list[Pass], state: RunState) -> Trial[list[Pass]]:
    """Trial 0 of the loop that a state is of, from its runs, which were made again.

    Raises InputError where they do not come out as they did.
    """
    measured = np.mean([output(run) for run in first], axis=0)
    error = output.reference - measured
    size = output.size(error)
    if not np.array_equal(size, state.loop.first_size):
        other = "by another version, on another machine, or from files that have changed since"
        raise InputError(
            f"it cannot be gone on from: its first run does not come out the same here, {other}; "
            "with another --seed its correction is taken over"
        )
    correction = first[0].recording.correction
    return Trial(0, correction, measured, error, first, first_size=size)
