"""Design variables of the law, and their normalised form: the action of the env, in the table of
`armside.sim.tuning.env.IlcTuningEnv`.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..laser.design import Design

SIX = 6
"""Axes of the robots of the thesis, where no other number is given."""


class Scale(Enum):
    """Spacing of a variable's values."""

    LINEAR = "linear"
    WHOLE = "whole numbers"
    LOGARITHMIC = "logarithmic"


@dataclass(frozen=True)
class Variable:
    """One design variable and its range."""

    name: str
    low: float
    high: float
    unit: str
    scale: Scale

    def physical(self, normalised: Array) -> Array:
        """From [-1, 1] to [low, high], any shape."""
        part = 0.5 * (np.asarray(normalised, dtype=np.float64) + 1.0)
        if self.scale is Scale.LOGARITHMIC:
            # Clipped: the power of a ratio may miss the end of the range by a rounding error.
            return np.clip(self.low * (self.high / self.low) ** part, self.low, self.high)
        value = self.low + part * (self.high - self.low)
        return np.rint(value) if self.scale is Scale.WHOLE else value

    def normalised(self, physical: Array) -> Array:
        """From [low, high] to [-1, 1], any shape. Raises ValueError outside."""
        value = np.asarray(physical, dtype=np.float64)
        if not ((value >= self.low) & (value <= self.high)).all():
            limits = f"[{self.low:g}, {self.high:g}] {self.unit}"
            raise ValueError(f"{self.name} must be in {limits}, got {value.tolist()}")
        if self.scale is Scale.LOGARITHMIC:
            return 2.0 * np.log(value / self.low) / np.log(self.high / self.low) - 1.0
        return 2.0 * (value - self.low) / (self.high - self.low) - 1.0


VARIABLES = (
    Variable("gamma", 0.1, 1.5, "", Scale.LINEAR),
    Variable("delta", 0.0, 25.0, "samples", Scale.WHOLE),
    Variable("cutoff", 1.0, 30.0, "Hz", Scale.LOGARITHMIC),
)


class Motors(Enum):
    """Designs of the motors: one for all, or one each."""

    SHARED = "shared"
    EACH = "each"

    def count(self, n_axes: int = SIX) -> int:
        """Values of one variable, for a robot of so many axes."""
        return 1 if self is Motors.SHARED else n_axes


def design_of(action: ArrayLike, motors: Motors, n_axes: int = SIX) -> Design:
    """The design that an action stands for.

    Raises ValueError for a wrong shape, NaN or values outside of [-1, 1]; names the first bad one.
    """
    count = motors.count(n_axes)
    expected = (len(VARIABLES) * count,)
    try:
        values = np.asarray(action).astype(np.float64, casting="same_kind")
    except (TypeError, ValueError):
        raise ValueError(f"an action must be {expected[0]} numbers, got {action!r}") from None
    if values.shape != expected:
        raise ValueError(f"an action must have shape {expected}, got {values.shape}")
    wrong = ~((values >= -1.0) & (values <= 1.0))  # true for NaN too
    if wrong.any():
        i = int(np.argmax(wrong))
        name = VARIABLES[i // count].name
        raise ValueError(f"an action must be in [-1, 1], got {values[i]} at index {i} ({name})")
    gamma, delta, cutoff = (
        tuple(v.physical(part).tolist())
        for v, part in zip(VARIABLES, values.reshape(len(VARIABLES), -1), strict=True)
    )
    return Design(gamma=gamma, delta=tuple(int(d) for d in delta), cutoff=cutoff)


def action_of(design: Design, motors: Motors, n_axes: int = SIX) -> np.ndarray:
    """The float32 action that stands for a design, to the rounding of float32.

    Raises ValueError for a design outside of the ranges, or of another number of motors.
    """
    parts, count = [], motors.count(n_axes)
    for variable in VARIABLES:
        value = np.array(getattr(design, variable.name), dtype=np.float64)
        if len(value) > 1 and motors is Motors.SHARED:
            several = f"{variable.name} has {len(value)} values"
            raise ValueError(f"{several}, but all motors share one design")
        if len(value) not in (1, count):
            raise ValueError(f"{variable.name} has {len(value)} values, the robot {count} motors")
        parts.append(variable.normalised(np.broadcast_to(value, count)))
    return np.concatenate(parts).astype(np.float32)
