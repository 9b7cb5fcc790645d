"""Matrix of systems for several inputs and outputs, such as the servos of all motors."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import records
from .peak import peak
from .products import largest_singular_value
from .state_space import RecordModel, StateSpace, is_record_model
from .system import Complex, System, require_stable


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
        if self._is_diagonal:
            columns = [row[i].simulate(signal[:, [i]]) for i, row in enumerate(self.entries)]
            return np.concatenate(columns, axis=1)
        from .block_recursion import filter_matrix  # imported here: compiled

        return filter_matrix(*self._coefficients, np.ascontiguousarray(signal))

    @cached_property
    def _is_diagonal(self) -> bool:
        return not any(
            s.b.any() for i, row in enumerate(self.entries) for j, s in enumerate(row) if i != j
        )

    @cached_property
    def _coefficients(self) -> tuple[Array, Array]:
        """b and a of all entries (n, n, order + 1), padded with zeros to the same length."""
        size = max(max(len(s.b), len(s.a)) for row in self.entries for s in row)
        b, a = np.zeros((2, len(self.entries), len(self.entries), size))
        for i, row in enumerate(self.entries):
            for j, system in enumerate(row):
                b[i, j, : len(system.b)], a[i, j, : len(system.a)] = system.b, system.a
        return b, a

    @records("signal")
    def adjoint(self, signal: Array) -> Array:
        """T^T e on the finite record (N, n): the time-reversed record filtered, then reversed."""
        return self.transposed.simulate(signal[::-1])[::-1]

    @property
    def n_inputs(self) -> int:
        return len(self.entries)

    @property
    def n_outputs(self) -> int:
        return len(self.entries)

    def coupled_columns(self) -> list[list[int]]:
        """Columns that are coupled to each other, directly or through others."""
        n = len(self.entries)
        linked = np.eye(n, dtype=bool) | [[s.b.any() for s in row] for row in self.entries]
        reach = np.linalg.matrix_power((linked | linked.T).astype(float), n) > 0.0
        return [np.flatnonzero(row).tolist() for row in np.unique(reach, axis=0)[::-1]]

    def submatrix(self, columns: list[int]) -> "SystemMatrix":
        return SystemMatrix(tuple(tuple(self.entries[i][j] for j in columns) for i in columns))

    @cached_property
    def transposed(self) -> "SystemMatrix":
        return SystemMatrix(tuple(zip(*self.entries, strict=True)))


Model = System | SystemMatrix | StateSpace
"""Time-invariant T_u: one system, used for each column, a matrix of systems or a state space."""
AnyModel = Model | RecordModel
"""T_u of a finite record."""


def check_inputs(T_u: AnyModel, n_columns: int) -> None:
    """Raise ValueError if a model, except one system, does not fit records with n columns."""
    if not isinstance(T_u, System) and T_u.n_inputs != n_columns:
        raise ValueError(f"T_u has {T_u.n_inputs} inputs, the record {n_columns}")


def check_model(T_u: AnyModel) -> None:
    """Raise ValueError for a time-invariant model that is unstable, or something that is no model.

    A model that varies along the record is neither stable nor unstable.
    """
    if isinstance(T_u, Model):
        require_stable(T_u, "T_u")
    elif not is_record_model(T_u):
        needed = "n_inputs, n_outputs, simulate and adjoint"
        raise ValueError(f"T_u must be a model with {needed}, got {type(T_u).__name__}")


def require_time_invariant(T_u: AnyModel, what: str) -> Model:
    """The model, if it is time-invariant. Raises ValueError with `what` needs it otherwise."""
    if not isinstance(T_u, Model):
        kinds = "a System, a SystemMatrix or a StateSpace"
        raise ValueError(f"{what} needs {kinds} as T_u, got {type(T_u).__name__}")
    return T_u


def n_outputs_of(T_u: AnyModel, n_columns: int) -> int:
    """Columns of the output for corrections of n_columns: as many for one system."""
    return n_columns if isinstance(T_u, System) else T_u.n_outputs


def largest_gain(model: AnyModel) -> float:
    """max over frequency of |T_u|, the largest singular value for a matrix; from above, to 1e-9.

    Of a model that covers n_samples of a record: the 2-norm of that map.
    """
    if not isinstance(model, Model):
        if (n_samples := getattr(model, "n_samples", 0)) < 1:
            raise ValueError("the largest gain needs a model that states its n_samples")
        return largest_singular_value(model, n_samples)

    def power(omega: Array) -> Array:
        T = model.response(omega)
        size = np.abs(T) if T.ndim == 1 else np.linalg.norm(T, ord=2, axis=(1, 2))
        return np.square(size)

    return float(np.sqrt(peak(power, model.all_poles).bound))


def require_effect(model: AnyModel) -> float:
    """Its `largest_gain`. Raises ValueError for a model that is 0."""
    if not (largest := largest_gain(model)) > 0.0:
        raise ValueError("T_u is 0: no correction has an effect")
    return largest


def single_response(T_u: Model, omega: ArrayLike) -> Complex:
    """(M,) at omega [rad/sample]. ValueError unless the model has one input and one output."""
    if (T_u.n_inputs, T_u.n_outputs) != (1, 1):
        given = f"{T_u.n_inputs} and {T_u.n_outputs}"
        raise ValueError(f"T_u must have one input and one output, got {given}")
    response = T_u.response(omega)
    return response if response.ndim == 1 else response[:, 0, 0]
