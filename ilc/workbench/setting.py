"""Facts of a task that a law is built for."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from armside.arrays import Array

from ..analysis.proposal import propose
from ..filters import ZeroPhaseButterworth
from ..models.system import System
from ..models.system_matrix import Model


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
