"""A plant with its reference and what is known of it: what several laws are compared on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array

from ..models.system_matrix import Model


def _nothing(result: Any) -> Mapping[str, float]:
    return {}


def _no_generators(plant: Any) -> Sequence[np.random.Generator]:
    return ()


def _nothing_to_close() -> None:
    pass


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """Plant of a comparison. `start` makes it anew for each law, in the same initial state."""

    name: str
    reference: Array
    """r, shape (N, n)."""
    sample_time: float
    """[s]."""
    start: Callable[[int], Any]
    """The plant of a repetition: the same parameters, other noise. Has `run(correction)`."""
    output_of: Callable[[Any], Any] = np.asarray
    """y, shape (N, n), from what the plant returns."""
    measures_of: Callable[[Any], Mapping[str, float]] = _nothing
    """More measures of a run by name, such as the error of the arm."""
    generators_of: Callable[[Any], Sequence[np.random.Generator]] = _no_generators
    """Sources of noise in a plant, whose state an interrupted experiment needs."""
    model: Model | None = None
    """Assumed T_u; None: unknown."""
    exact: bool = False
    """The plant is linear and `model` is its T_u."""
    cutoff: float | None = None
    """Default cutoff of Q [Hz]; None: a tenth of the sample rate."""
    place: Array | None = None
    """(N,) [m], place along a path at each sample, by which corrections are carried over."""
    design: tuple[float, int] | None = None
    """Default gamma and delta; None: proposed for the model."""

    close: Callable[[], None] = _nothing_to_close
    """Gives back what the plant holds, such as a connection."""

    @property
    def default_cutoff(self) -> float:
        """[Hz]."""
        return 0.1 / self.sample_time if self.cutoff is None else self.cutoff
