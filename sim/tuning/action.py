"""What an action of the env stands for: a design of the law, or the next correction itself.

A design is its variables in their normalised form, in the table of
`armside.sim.tuning.env.IlcTuningEnv`. A correction u of an axis is its size times the sum of the
action's coefficients in [-1, 1] times basis functions, around the correction of a twin if there is
one. The size of an axis is REACH times the RMS of its error before learning, which a controller
knows.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.ilc.laws.model_free import b_splines

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
    """The design that an action stands for. Raises ValueError as `_checked`."""
    count = motors.count(n_axes)
    values = _checked(action, len(VARIABLES) * count, lambda i: VARIABLES[i // count].name)
    gamma, delta, cutoff = (
        tuple(v.physical(part).tolist())
        for v, part in zip(VARIABLES, values.reshape(len(VARIABLES), -1), strict=True)
    )
    return Design(gamma=gamma, delta=tuple(int(d) for d in delta), cutoff=cutoff)


def action_of(design: Design, motors: Motors, n_axes: int = SIX) -> np.ndarray:
    """The float32 action that stands for a design. Raises ValueError for a design outside of the
    ranges, or of another number of motors."""
    parts, count = [], motors.count(n_axes)
    for variable in VARIABLES:
        value = np.array(getattr(design, variable.name), dtype=np.float64)
        if len(value) not in (1, count):
            shared = motors is Motors.SHARED
            known = "but all motors share one design" if shared else f"the robot {count} motors"
            raise ValueError(f"{variable.name} has {len(value)} values, {known}")
        parts.append(variable.normalised(np.broadcast_to(value, count)))
    return np.concatenate(parts).astype(np.float32)


REACH = 5.0
"""Size of a coefficient of 1 over the RMS of the first error. ESTIMATE: errors peak at three to
four times their RMS, as friction reverses."""
LARGEST_COUNT = 60
"""Functions of one axis, at most."""


BASES = ("b-splines", "harmonics")
"""Functions that are zero at both ends of a record: cubic B-splines with evenly spaced knots, less
the two that are not; or sin(j pi t / T), j = 1, 2, ..., over its length T."""


@lru_cache(maxsize=64)
def _functions(kind: str, count: int, n_samples: int) -> tuple[Array, Array]:
    """Functions (N, m), and the matrix (m, N) that fits a signal with them."""
    if kind == "b-splines":
        functions = b_splines(n_samples, count + 2)[:, 1:-1]
    else:
        place = np.linspace(0.0, np.pi, n_samples)
        functions = np.sin(np.outer(place, np.arange(1, count + 1)))
        functions[[0, -1]] = 0.0
    return np.asarray(functions), np.asarray(np.linalg.pinv(functions), dtype=np.float64)


@dataclass(frozen=True)
class CorrectionBasis:
    """Functions of every axis: a kind of `BASES`, and how many."""

    kind: str
    count: int

    def fit(self, signal: Array, size: Array) -> Array:
        """(n, m), least-squares coefficients of a signal (N, n) in units of size (n,)."""
        inverse = _functions(self.kind, self.count, len(signal))[1]
        return (inverse @ signal).T / np.where(size > 0.0, size, 1.0)[:, np.newaxis]

    def decoded(self, action: ArrayLike, n_axes: int) -> "Coefficients":
        """Coefficients of an action (n m,), axis by axis. Raises ValueError as `_checked`."""
        m = self.count
        values = _checked(
            action, n_axes * m, lambda i: f"function {i % m + 1} of axis {i // m + 1}"
        )
        return Coefficients(self, values.reshape(n_axes, m))


@dataclass(frozen=True, eq=False)
class Coefficients:
    """A correction as an action chooses it."""

    basis: CorrectionBasis
    values: Array = field(repr=False)
    """(n, m) in [-1, 1]."""

    def correction(self, n_samples: int, size: Array) -> Array:
        """(N, n) [rad], arm side, in units of size (n,) [rad]."""
        functions = _functions(self.basis.kind, self.basis.count, n_samples)[0]
        return functions @ (self.values * size[:, np.newaxis]).T

    def arrays(self, n_axes: int) -> dict[str, np.ndarray]:
        """The coefficients under their name, for `info`."""
        return {"coefficients": self.values.copy()}


def _checked(action: ArrayLike, size: int, name: Callable[[int], str]) -> Array:
    """(size,), the values of an action. Raises ValueError for a wrong shape, NaN or values outside
    of [-1, 1], with the index and the name of the first one."""
    try:
        values = np.asarray(action).astype(np.float64, casting="same_kind")
    except (TypeError, ValueError):
        raise ValueError(f"an action must be {size} numbers, got {action!r}") from None
    if values.shape != (size,):
        raise ValueError(f"an action must have shape {(size,)}, got {values.shape}")
    wrong = ~((values >= -1.0) & (values <= 1.0))  # true for NaN too
    if wrong.any():
        i = int(np.argmax(wrong))
        raise ValueError(f"an action must be in [-1, 1], got {values[i]} at index {i} ({name(i)})")
    return values
