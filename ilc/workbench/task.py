"""A plant with its reference and what is known of it: what laws are built for and compared on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from armside.arrays import Array

from ..analysis.proposal import propose
from ..filters import ZeroPhaseButterworth
from ..models.system import System
from ..models.system_matrix import Model
from ..records import as_number, as_real, as_record, records


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """Record, model and defaults of the design variables."""

    sample_time: float
    """[s]."""
    reference: Array
    """r, shape (N, n)."""
    model: Model | None
    """Assumed T_u; None: none is known."""
    cutoff: float
    """Cutoff of Q where a law states none [Hz]."""
    experiment: Callable[[Array], Array]
    """Run of the plant beside the loop's own, for laws that measure responses."""
    design: tuple[float, int] | None = None
    """gamma and delta where the heuristic law states none; None: those that `propose` finds."""

    @property
    def n_samples(self) -> int:
        return len(self.reference)

    @property
    def n_columns(self) -> int:
        return self.reference.shape[1]

    def Q(self, cutoff: float | None) -> ZeroPhaseButterworth:
        """Zero-phase low-pass; None for the default cutoff."""
        return ZeroPhaseButterworth(self.cutoff if cutoff is None else cutoff, self.sample_time)

    def T_u(self, law: str) -> Model:
        """The model. Raises ValueError where a law needs one that is not there."""
        if self.model is None:
            raise ValueError(f"{law} needs a model of the plant: give --model FILE")
        return self.model

    def shared_model(self, law: str) -> System:
        """The model, if it is one system for all columns. Raises ValueError otherwise."""
        model = self.T_u(law)
        if not isinstance(model, System):
            raise ValueError(f"{law} needs one transfer function as its model, for all columns")
        return model

    @cached_property
    def proposed(self) -> tuple[float, int]:
        """gamma and delta of the heuristic law at the default cutoff."""
        if self.design is not None:
            return self.design
        if not isinstance(self.model, System):
            return 0.9, 0
        found = propose(self.model, self.cutoff)
        return found.gamma, found.delta


def _nothing(*_: Any) -> Any:
    """No measures, generators, conditions or connections: a default that can be pickled."""
    return {}


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
    generators_of: Callable[[Any], Sequence[np.random.Generator]] = _nothing
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

    check: Callable[[Array], Any] = _nothing
    """Raises ValueError for a correction (N, n) that the plant would not take."""
    close: Callable[[], Any] = _nothing
    """Gives back what the plant holds, such as a connection."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "reference", as_record(self.reference, "reference"))
        as_number(self.sample_time, "sample_time", 0.0)

    @property
    def default_cutoff(self) -> float:
        """[Hz]."""
        return 0.1 / self.sample_time if self.cutoff is None else self.cutoff


@records("correction")
def along_path(correction: Array, place: Array, wanted: Array) -> Array:
    """The correction (N, n) learned at `place` (N,), at the places `wanted` (M,): shape (M, n).

    Linear in between; before and beyond the path that was learned it keeps its end values. This
    takes the correction for a function of the place alone, so delays of the servo are not scaled.
    place: [m], not decreasing.
    """
    place, wanted = as_real(place, "place"), as_real(wanted, "wanted")
    if place.shape != (len(correction),) or not (np.diff(place) >= 0.0).all():
        raise ValueError(f"place must be {len(correction)} numbers that do not decrease")
    if not np.isfinite(wanted).all():
        raise ValueError("wanted must be finite")
    first = np.flatnonzero(place <= place[0])[-1]  # the end of the rest before
    moving = np.concatenate(([True], np.diff(place[first:]) > 0.0))
    known, values = place[first:][moving], correction[first:][moving]
    return np.stack([np.interp(wanted, known, column) for column in values.T], axis=1)
