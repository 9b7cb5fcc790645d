"""Unknown parameters of a robot individual as one vector, with their prior distribution.

    theta = (friction law, torque ripple | mass | springs, lost motion, gear error, geometry)

Factors of friction enter as logarithms. Springs enter as compliance, to which the tool's deflection
is proportional: factor = 1 / (1 + z) of a stiffness. A ripple or gear error of unknown phase
enters as cosine and sine relative to the amplitude of the design. The prior is a normal
distribution around the design: what a data sheet of the type states.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array

from ..robot.alien import AlienEffect
from ..robot.drives import N_HARMONICS
from ..robot.individual import Individual
from ..robot.mjcf import N_AXES
from .simulation import DIRECTIONS, LINKS, MEAN, hinges

_STIFFEST = 0.25
"""Least compliance of a spring relative to the design."""


@dataclass(frozen=True)
class Block:
    """Parameters of one kind."""

    name: str
    shape: tuple[int, ...]
    prior: float
    """Standard deviation before any cut: of log(factor), of a relative amplitude, in [m] or [rad].
    All ESTIMATES."""
    mean: float = 0.0
    lower: float = -np.inf
    upper: float = np.inf
    """Bounds, beyond which a value makes no sense or its simulation no solution."""
    step: float = np.inf
    """Largest change in one step of the identification, within which the tool's path is linear."""

    @property
    def size(self) -> int:
        return int(np.prod(self.shape))


FRICTION = (
    Block("friction_constant", (N_AXES,), 0.3, lower=-1.0, upper=1.0),
    Block("friction_load", (N_AXES,), 0.3, lower=-1.0, upper=1.0),
    Block("static_excess", (N_AXES,), 0.3, lower=-1.0, upper=1.0),
    Block("stribeck_speed", (N_AXES,), 0.3, lower=-1.0, upper=1.0),
    Block("viscous", (N_AXES,), 0.3, lower=-1.0, upper=1.0),
    Block("bristle_stiffness", (N_AXES,), 0.3, lower=-1.0, upper=1.0),
    Block("ripple", (N_AXES, 2), 0.75),
)
"""Identified from torque: log factors, and (cosine, sine) of the ripple."""


MASS = Block("mass", (N_AXES,), 0.02, lower=-0.1, upper=0.1)
"""Mass of each link, from the torque that carries it and from the tool."""

HYSTERESIS = Block("hysteresis", (1,), 1.0, lower=0.0, upper=5.0)
"""Size of the effect of that name of `armside.sim.robot.alien`, one for all gears: of a twin that
is not believed without."""


def tool_blocks(n_structure: int, hysteresis: bool = False) -> tuple[Block, ...]:
    """Parameters identified from the tool, for a design with n hinges of the structure."""
    links = len(LINKS)
    return (
        *(HYSTERESIS,) * hysteresis,
        Block("gear_stiffness", (N_AXES,), 0.3, lower=_STIFFEST - 1.0, upper=2.0),
        Block("structure_stiffness", (n_structure,), 0.3, lower=_STIFFEST - 1.0, upper=2.0),
        Block("bending", (links, len(DIRECTIONS)), 1.0, lower=-MEAN, upper=6.0, step=1.0),
        Block("bending_place", (links,), 0.15, lower=-0.3, upper=0.3, step=0.1),
        Block("lost_motion", (N_AXES,), 0.3, lower=-1.0, upper=1.0),
        Block("gear_error", (N_AXES, N_HARMONICS, 2), 0.75),
        Block("position", (N_AXES, 3), 0.7e-3),
        Block("orientation", (N_AXES, 3), 0.7e-3),
    )


_LOGARITHMS = (*(block.name for block in FRICTION if block.name != "ripple"), "lost_motion")
SPRINGS = ("gear_stiffness", "structure_stiffness")
BENDING = ("bending", "bending_place")


@dataclass(frozen=True)
class Parameters:
    """Vector theta of named blocks."""

    blocks: tuple[Block, ...]

    @property
    def size(self) -> int:
        return sum(block.size for block in self.blocks)

    @property
    def mean(self) -> Array:
        """(m,), of the prior."""
        return self._each("mean")

    @property
    def standard_deviation(self) -> Array:
        """(m,), of the prior."""
        return self._each("prior")

    @property
    def lower(self) -> Array:
        """(m,), bounds, as `upper`."""
        return self._each("lower")

    @property
    def upper(self) -> Array:
        return self._each("upper")

    @property
    def step(self) -> Array:
        """(m,), largest change in one step."""
        return self._each("step")

    def _each(self, name: str) -> Array:
        return np.concatenate([np.full(b.size, getattr(b, name)) for b in self.blocks])

    @property
    def names(self) -> tuple[str, ...]:
        """(m,), like `lost_motion 3` or `gear_error 2 4 sine`: axis, order."""
        return tuple(
            " ".join((block.name, *(str(i + 1) for i in index)))
            for block in self.blocks
            for index in np.ndindex(block.shape)
        )

    def at(self, name: str) -> slice:
        """Entries of a block."""
        start = 0
        for block in self.blocks:
            if block.name == name:
                return slice(start, start + block.size)
            start += block.size
        known = ", ".join(block.name for block in self.blocks)
        raise ValueError(f"Unknown block {name!r}. Blocks: {known}")

    def individual(self, theta: Array, gear_phase: Array) -> Individual:
        """The individual of a vector; gear_phase: (6, 4) [rad], phases of the gear error in the
        robot's file, which are those of another individual."""
        values = {b.name: theta[self.at(b.name)].reshape(b.shape) for b in self.blocks}
        factors: dict[str, Any] = {name: np.exp(values[name]) for name in _LOGARITHMS}
        springs = [1.0 / np.maximum(1.0 + values[name], _STIFFEST) for name in SPRINGS]
        # A step that ends at the bound of 0 may be below it by rounding.
        sizes = np.maximum(values.get(HYSTERESIS.name, np.zeros(0)), 0.0).tolist()
        ripple, error = values["ripple"], values["gear_error"]
        ripple_phase = np.arctan2(ripple[:, 1], ripple[:, 0])
        error_phase = np.arctan2(error[..., 1], error[..., 0])
        return Individual(
            **factors,
            mass=1.0 + values["mass"],
            gear_stiffness=springs[0],
            structure_stiffness=springs[1],
            hidden=hinges(*(values[name] for name in BENDING)),
            alien=tuple(AlienEffect(HYSTERESIS.name, size) for size in sizes),
            ripple=np.hypot(ripple[:, 0], ripple[:, 1]),
            ripple_phase=ripple_phase,
            gear_error=np.hypot(error[..., 0], error[..., 1]),
            # An individual's ripple phase turns its gear error too.
            gear_error_phase=error_phase - gear_phase - ripple_phase[:, None],
            position=values["position"],
            orientation=values["orientation"],
        )
