"""Design of the heuristic law: its variables, that of the thesis, and the default of a robot."""

from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array, check_numbers
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic

from ..cell import Cell
from ..robot.virtual_robot import LOG_PERIOD


@dataclass(frozen=True, kw_only=True)
class Design:
    """Design variables of Q(u + gamma q^delta e), each one value for all motors or one for each."""

    gamma: tuple[float, ...]
    delta: tuple[int, ...]
    """[samples], >= 0: a robot answers later than it is corrected."""
    cutoff: tuple[float, ...]
    """[Hz]."""
    law: Heuristic = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_numbers(self, "gamma", "delta", "cutoff", several=True)
        gamma = self.gamma[0] if len(self.gamma) == 1 else self.gamma
        delta = self.delta[0] if len(self.delta) == 1 else self.delta
        cutoff = self.cutoff[0] if len(self.cutoff) == 1 else self.cutoff
        Q = ZeroPhaseButterworth(cutoff, LOG_PERIOD)
        object.__setattr__(self, "law", Heuristic(Q=Q, gamma=gamma, delta=delta))
        if early := [given for given in self.delta if given < 0]:
            raise ValueError(f"delta must be >= 0 samples, got {early[0]}")

    def arrays(self, n_axes: int) -> dict[str, Array]:
        """Values of each motor by name: (n_axes,) arrays."""
        return {
            name: np.array(np.broadcast_to(getattr(self, name), n_axes), dtype=np.float64)
            for name in ("gamma", "delta", "cutoff")
        }


THESIS = Design(gamma=(0.9,), delta=(3,), cutoff=(10.0,))
"""Design of thesis chapter 9."""


def default_design(cell: Cell) -> Design:
    """Design of a robot for learning from motor angles."""
    own = cell.learning
    if own is None:
        return THESIS
    return Design(gamma=(own.gamma,), delta=(own.delta,), cutoff=(own.cutoff,))
