"""Matrix of systems for several inputs and outputs, such as the servos of all motors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import records
from .peak import peak
from .system import Complex, System


@dataclass(frozen=True, eq=False)
class SystemMatrix:
    """y_i = sum_j T_ij u_j; square, all entries with one sample time."""

    entries: tuple[tuple[System, ...], ...]

    def __post_init__(self) -> None:
        n = len(self.entries)
        if n == 0 or any(len(row) != n for row in self.entries):
            lengths = [len(row) for row in self.entries]
            raise ValueError(f"entries must be a square matrix, got rows of {lengths}")
        times = {system.sample_time for row in self.entries for system in row}
        if max(times) - min(times) > 1e-12 * max(times):
            raise ValueError(f"entries must have one sample time, got {sorted(times)} s")

    @classmethod
    def diagonal(cls, systems: Sequence[System]) -> "SystemMatrix":
        """Diagonal matrix: motors without coupling."""
        zero = System(np.zeros(1), np.ones(1), systems[0].sample_time)
        n = len(systems)
        return cls(tuple(tuple(systems[i] if i == j else zero for j in range(n)) for i in range(n)))

    @property
    def sample_time(self) -> float:
        return self.entries[0][0].sample_time

    @property
    def is_stable(self) -> bool:
        return all(system.is_stable for row in self.entries for system in row)

    @property
    def poles(self) -> Complex:
        return np.concatenate([system.poles for row in self.entries for system in row])

    @property
    def all_poles(self) -> Complex:
        """Poles of all entries, those at the origin included."""
        entries = [s for row in self.entries for s in row if s.b.any()]
        return np.concatenate([np.zeros(0), *(s.all_poles for s in entries)]).astype(np.complex128)

    def response(self, omega: ArrayLike) -> Complex:
        """Shape (M, n, n) at omega (M,) [rad/sample]."""
        rows = [np.stack([s.response(omega) for s in row], axis=-1) for row in self.entries]
        return np.stack(rows, axis=-2)

    @records("signal")
    def simulate(self, signal: Array) -> Array:
        """Outputs (N, n) for inputs (N, n), from zero state."""
        output = np.zeros_like(signal)
        for i, row in enumerate(self.entries):
            for j, system in enumerate(row):
                if system.b.any():
                    output[:, [i]] += system.simulate(signal[:, [j]])
        return output

    def coupled_columns(self) -> list[list[int]]:
        """Columns that are coupled to each other, directly or through others."""
        n = len(self.entries)
        linked = np.eye(n, dtype=bool) | [[s.b.any() for s in row] for row in self.entries]
        reach = np.linalg.matrix_power((linked | linked.T).astype(float), n) > 0.0
        return [np.flatnonzero(row).tolist() for row in np.unique(reach, axis=0)[::-1]]

    def submatrix(self, columns: list[int]) -> "SystemMatrix":
        return SystemMatrix(tuple(tuple(self.entries[i][j] for j in columns) for i in columns))

    @property
    def transposed(self) -> "SystemMatrix":
        return SystemMatrix(tuple(zip(*self.entries, strict=True)))


Model = System | SystemMatrix
"""T_u: one system, used for each column, or a matrix of systems."""


def check_inputs(T_u: Model, n_columns: int) -> None:
    """Raise ValueError if a matrix of systems does not fit records with n columns."""
    if isinstance(T_u, SystemMatrix) and len(T_u.entries) != n_columns:
        raise ValueError(f"T_u has {len(T_u.entries)} inputs, the record {n_columns}")


@records("signal")
def adjoint(model: Model, signal: Array) -> Array:
    """T^T e on the finite record: filter the time-reversed record, then reverse."""
    back = model.transposed if isinstance(model, SystemMatrix) else model
    return back.simulate(signal[::-1])[::-1]


def largest_gain(model: Model) -> float:
    """max over frequency of |T_u|, the largest singular value for a matrix; from above, to 1e-9."""
    largest = peak(lambda omega: gain_squared(model.response(omega)), model.all_poles)
    return float(np.sqrt(largest.bound))


def gain_squared(response: Complex) -> Array:
    """|T|^2 of responses (M,), or the largest singular value squared of (M, p, n)."""
    if response.ndim == 1:
        return np.square(np.abs(response))
    return np.square(np.linalg.norm(response, ord=2, axis=(1, 2)))
