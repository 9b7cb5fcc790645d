"""Linear models on finite records, y = T u and its adjoint: the interface, and models with states.

x(t + 1) = A x(t) + B u(t)        y(t) = C x(t) + D u(t)        x(0) = 0

`StateSpace` is time-invariant; the matrices of `TimeVarying` are those of each sample, such as of
a robot linearised along its path. A model of one's own needs the four members of `RecordModel`;
laws and finite-record analysis ask for nothing else.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_number, as_real, records
from .blocks import Realisation, filtered
from .system import Complex, unit_circle, zero_order_hold

_CONDITIONED = 1e4
"""Condition of the eigenvectors up to which recursions run in modes: four digits of sixteen."""


class RecordModel(Protocol):
    """Linear map T of records at rest before, from n_inputs to n_outputs columns."""

    @property
    def n_inputs(self) -> int: ...
    @property
    def n_outputs(self) -> int: ...

    def simulate(self, signal: Array, /) -> Array:
        """T u, shape (N, n_outputs), for u of shape (N, n_inputs)."""
        ...

    def adjoint(self, signal: Array, /) -> Array:
        """T^T e, shape (N, n_inputs), for e of shape (N, n_outputs)."""
        ...


def is_record_model(model: Any) -> TypeGuard[RecordModel]:
    """The object has the members of a `RecordModel`."""
    return all(hasattr(model, name) for name in ("n_inputs", "n_outputs", "simulate", "adjoint"))


@dataclass(frozen=True, eq=False)
class _Matrices:
    """Maps of records by matrices, those of `TimeVarying` with an axis of time first; read-only."""

    A: Array
    B: Array
    C: Array
    D: Array | None = None

    def _hold(self, dimensions: int) -> None:
        known = matrices(self.A, self.B, self.C, self.D, dimensions)
        for name, M in zip("ABCD", known, strict=True):
            M.setflags(write=False)
            object.__setattr__(self, name, M)

    @property
    def feedthrough(self) -> Array:
        """D, shape (p, m)."""
        assert self.D is not None
        return self.D

    @property
    def n_inputs(self) -> int:
        return self.B.shape[-1]

    @property
    def n_outputs(self) -> int:
        return self.C.shape[-2]

    @cached_property
    def realisation(self) -> Realisation:
        return Realisation.of(self.A, self.B, self.C, self.feedthrough)

    def filtered_realisation(self, taps: Array) -> Realisation:
        """Of F T, F the finite impulse response `taps`."""
        if len(taps) > 1:
            return Realisation.of(*filtered(self.A, self.B, self.C, self.feedthrough, taps))
        one = self.realisation
        return Realisation(one.A, one.first, one.B, taps[0] * one.C, taps[0] * one.D)

    @records("signal")
    def simulate(self, signal: Array) -> Array:
        """Outputs (N, p) for inputs (N, m), from zero state."""
        self._check(signal, self.n_inputs, "inputs")
        return self.realisation.simulate(signal)

    @records("signal")
    def adjoint(self, signal: Array) -> Array:
        """T^T e, shape (N, m), for e (N, p)."""
        self._check(signal, self.n_outputs, "outputs")
        return self.realisation.adjoint(signal)

    def _check(self, signal: Array, width: int, what: str) -> None:
        if (covered := getattr(self, "n_samples", len(signal))) != len(signal):
            raise ValueError(f"T_u covers {covered} samples, the record {len(signal)}")
        if signal.shape[1] != width:
            raise ValueError(f"T_u has {width} {what}, the record {signal.shape[1]}")


@dataclass(frozen=True, eq=False)
class StateSpace(_Matrices):
    """Matrices A (n, n), B (n, m), C (p, n) and D (p, m), 0 if None; read-only."""

    sample_time: float = 1.0
    """[s]."""

    def __post_init__(self) -> None:
        as_number(self.sample_time, "sample_time", 0.0)
        self._hold(2)

    @classmethod
    def from_continuous(
        cls, A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike | None, sample_time: float
    ) -> "StateSpace":
        """From x' = A x + B u, y = C x + D u with u held over each sample (zero-order hold)."""
        as_number(sample_time, "sample_time", 0.0)
        known = matrices(A, B, C, D, dimensions=2)
        return cls(*zero_order_hold(known[0], known[1], sample_time), *known[2:], sample_time)

    @property
    def poles(self) -> Complex:
        """Eigenvalues of A."""
        return np.diag(self._schur[0])

    all_poles = poles
    """Poles, those at the origin included."""

    @property
    def is_stable(self) -> bool:
        """All eigenvalues of A, as they are computed, are inside the unit circle."""
        return bool((np.abs(self.poles) < 1.0).all())

    @property
    def transposed(self) -> "StateSpace":
        return StateSpace(self.A.T, self.C.T, self.B.T, self.feedthrough.T, self.sample_time)

    @cached_property
    def realisation(self) -> Realisation:
        """In modes where the eigenvectors are well conditioned, else in one block."""
        if (modes := _modes(self.A)) is None:
            return Realisation.of(self.A, self.B, self.C, self.feedthrough)
        blocks, V = modes
        B: Array = np.linalg.solve(V, self.B).astype(np.float64)
        return Realisation.of_blocks(blocks, B, self.C @ V, self.feedthrough)

    def response(self, omega: ArrayLike) -> Complex:
        """Shape (M, p, m) at omega (M,) [rad/sample]."""
        # (z - T)^-1 Z^H B for the Schur form A = Z T Z^H, all z at once
        (T, Z), z = self._schur, np.atleast_1d(unit_circle(omega))
        right = Z.conj().T @ self.B
        X = np.empty((len(z), *right.shape), dtype=np.complex128)
        for i in range(len(T) - 1, -1, -1):
            above = np.tensordot(X[:, i + 1 :], T[i, i + 1 :], axes=(1, 0))
            X[:, i] = (right[i] + above) / (z - T[i, i])[:, None]
        return self.C @ Z @ X + self.feedthrough

    @cached_property
    def _schur(self) -> tuple[Complex, Complex]:
        from scipy.linalg import schur

        T, Z, *_ = schur(self.A, output="complex")
        return np.asarray(T), np.asarray(Z)


@dataclass(frozen=True, eq=False)
class TimeVarying(_Matrices):
    """Matrices of each sample: A (N, n, n), B (N, n, m), C (N, p, n), D (N, p, m) or None for 0."""

    def __post_init__(self) -> None:
        self._hold(3)

    @property
    def n_samples(self) -> int:
        return len(self.A)


def matrices(
    A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike | None, dimensions: int
) -> tuple[Array, Array, Array, Array]:
    """Copies that are finite and fit each other; 3 dimensions: with an axis of time first."""
    found = [np.array(as_real(M, name)) for M, name in ((A, "A"), (B, "B"), (C, "C"))]
    if all(M.ndim == dimensions for M in found):
        lead = found[0].shape[: dimensions - 2]
        zero = np.zeros((*lead, found[2].shape[-2], found[1].shape[-1]))
        found.append(zero if D is None else np.array(as_real(D, "D")))
        n, m = found[1].shape[-2:]
        p = found[2].shape[-2]
        wanted = [(*lead, *shape) for shape in ((n, n), (n, m), (p, n), (p, m))]
        if [M.shape for M in found] == wanted and m > 0 and p > 0 and 0 not in lead:
            if not all(np.isfinite(M).all() for M in found):
                raise ValueError("A, B, C, D must be finite")
            return found[0], found[1], found[2], found[3]
    shapes = ", ".join(str(M.shape) for M in found)
    first = "N, " if dimensions == 3 else ""
    needed = ", ".join(f"({first}{s})" for s in ("n, n", "n, m", "p, n", "p, m"))
    raise ValueError(f"A, B, C, D do not fit each other: {shapes}; needed are {needed}")


def _modes(A: Array) -> tuple[list[Array], Array] | None:
    """(blocks, V) with A V = V diag(blocks), or None if V is badly conditioned."""
    values, vectors = np.linalg.eig(A)
    blocks, columns = list[Array](), list[Array]()
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag == 0.0:
            blocks.append(np.array([[value.real]]))
            columns.append(vector.real)
        elif value.imag > 0.0:
            turn = np.array([[value.real, value.imag], [-value.imag, value.real]])
            blocks.append(turn)
            columns += [np.sqrt(2.0) * vector.real, np.sqrt(2.0) * vector.imag]
    if not columns:
        return None
    V = np.stack(columns, axis=1)
    good = V.shape == A.shape and np.linalg.cond(V) <= _CONDITIONED
    return (blocks, V) if good else None
