"""The next correction as an action: coefficients of basis functions, for each axis.

u of an axis is its size times the sum of the action's coefficients in [-1, 1] times the functions,
around the correction of a twin if there is one. The size of an axis is REACH times the RMS of its
error before learning, which a controller knows.
"""

from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.ilc.laws.model_free import b_splines

REACH = 5.0
"""Size of a coefficient of 1 over the RMS of the first error. ESTIMATE: errors peak at three to
four times their RMS, as friction reverses."""
LARGEST_COUNT = 60
"""Functions of one axis, at most."""


class BasisKind(Enum):
    """Kind of the functions, all of them zero at both ends of the record."""

    B_SPLINES = "b-splines"
    """Cubic, with evenly spaced knots; the two that are not zero at an end are left out."""
    HARMONICS = "harmonics"
    """sin(j pi t / T), j = 1, 2, ..., over the record of length T."""


@lru_cache(maxsize=64)
def _functions(kind: BasisKind, count: int, n_samples: int) -> tuple[Array, Array]:
    """Functions (N, m), and the matrix (m, N) that fits a signal with them."""
    if kind is BasisKind.B_SPLINES:
        functions = b_splines(n_samples, count + 2)[:, 1:-1]
    else:
        place = np.linspace(0.0, np.pi, n_samples)
        functions = np.sin(np.outer(place, np.arange(1, count + 1)))
        functions[[0, -1]] = 0.0
    return np.asarray(functions), np.asarray(np.linalg.pinv(functions), dtype=np.float64)


@dataclass(frozen=True)
class CorrectionBasis:
    """Functions of every axis. Raises ValueError for an unknown kind or a count out of range."""

    kind: str = "b-splines"
    count: int = 12

    def __post_init__(self) -> None:
        kinds = [kind.value for kind in BasisKind]
        if self.kind not in kinds:
            raise ValueError(f"Unknown basis {self.kind!r}. It can be: {', '.join(kinds)}")
        if not 2 <= self.count <= LARGEST_COUNT:
            raise ValueError(f"functions must be 2 to {LARGEST_COUNT}, got {self.count}")

    def functions(self, n_samples: int) -> Array:
        """(N, m), zero in the first and the last sample."""
        return _functions(BasisKind(self.kind), self.count, n_samples)[0]

    def fit(self, signal: Array, size: Array) -> Array:
        """(n, m), least-squares coefficients of a signal (N, n) in units of size (n,)."""
        inverse = _functions(BasisKind(self.kind), self.count, len(signal))[1]
        return (inverse @ signal).T / np.where(size > 0.0, size, 1.0)[:, np.newaxis]

    def decoded(self, action: ArrayLike, n_axes: int) -> "Coefficients":
        """Coefficients of an action (n m,), axis by axis. Raises ValueError for any other."""
        shape = (n_axes * self.count,)
        try:
            values = np.asarray(action).astype(np.float64, casting="same_kind")
        except (TypeError, ValueError):
            raise ValueError(f"an action must be {shape[0]} numbers, got {action!r}") from None
        if values.shape != shape:
            raise ValueError(f"an action must have shape {shape}, got {values.shape}")
        wrong = ~((values >= -1.0) & (values <= 1.0))  # true for NaN too
        if wrong.any():
            i = int(np.argmax(wrong))
            axis = f"function {i % self.count + 1} of axis {i // self.count + 1}"
            raise ValueError(f"an action must be in [-1, 1], got {values[i]} at index {i} ({axis})")
        return Coefficients(self, values.reshape(n_axes, self.count))


@dataclass(frozen=True, eq=False)
class Coefficients:
    """A correction as an action chooses it."""

    basis: CorrectionBasis
    values: Array = field(repr=False)
    """(n, m) in [-1, 1]."""

    def correction(self, n_samples: int, size: Array) -> Array:
        """(N, n) [rad], arm side, in units of size (n,) [rad]."""
        return self.basis.functions(n_samples) @ (self.values * size[:, np.newaxis]).T

    def arrays(self, n_axes: int) -> dict[str, np.ndarray]:
        """The coefficients under their name, for `info`."""
        return {"coefficients": self.values.copy()}
