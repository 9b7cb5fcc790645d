"""Discrete state-space models with any number of inputs and outputs, fixed or along the record.

x(t + 1) = A x(t) + B u(t)        y(t) = C x(t) + D u(t)        x(0) = 0

`StateSpace` is time-invariant; the matrices of `TimeVarying` are those of each sample, such as of
a robot linearised along its path.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_number, as_real, records
from .blocks import Realisation, filtered
from .lifted import check_shape
from .system import Complex, unit_circle, zero_order_hold

_CONDITIONED = 1e4
"""Condition of the eigenvectors up to which recursions run in modes: four digits of sixteen."""


class _OnRecords:
    """Maps of records by the `realisation` of a model, which has `n_inputs` and `n_outputs`."""

    @records("signal")
    def simulate(self: Any, signal: Array) -> Array:
        """Outputs (N, p) for inputs (N, m), from zero state."""
        check_shape(self, signal.shape, self.n_inputs, "inputs")
        return self.realisation.simulate(signal)

    @records("signal")
    def adjoint(self: Any, signal: Array) -> Array:
        """T^T e, shape (N, m), for e (N, p)."""
        check_shape(self, signal.shape, self.n_outputs, "outputs")
        return self.realisation.adjoint(signal)


@dataclass(frozen=True, eq=False)
class StateSpace(_OnRecords):
    """Matrices A (n, n), B (n, m), C (p, n) and D (p, m), 0 if None; read-only."""

    A: Array
    B: Array
    C: Array
    D: Array | None = None
    sample_time: float = 1.0
    """[s]."""

    def __post_init__(self) -> None:
        as_number(self.sample_time, "sample_time", 0.0)
        A, B, C, D = matrices(self.A, self.B, self.C, self.D, dimensions=2)
        for name, M in zip("ABCD", (A, B, C, D), strict=True):
            M.setflags(write=False)
            object.__setattr__(self, name, M)

    @classmethod
    def from_continuous(
        cls, A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike | None, sample_time: float
    ) -> "StateSpace":
        """From x' = A x + B u, y = C x + D u with u held over each sample (zero-order hold)."""
        as_number(sample_time, "sample_time", 0.0)
        known = matrices(A, B, C, D, dimensions=2)
        return cls(*zero_order_hold(known[0], known[1], sample_time), *known[2:], sample_time)

    @property
    def feedthrough(self) -> Array:
        """D, shape (p, m)."""
        return np.zeros((len(self.C), self.B.shape[1])) if self.D is None else self.D

    @property
    def n_inputs(self) -> int:
        return self.B.shape[1]

    @property
    def n_outputs(self) -> int:
        return len(self.C)

    @property
    def poles(self) -> Complex:
        """Eigenvalues of A."""
        return np.diag(self._schur[0])

    @property
    def all_poles(self) -> Complex:
        """Poles, those at the origin included."""
        return self.poles

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
        modes = _modes(self.A)
        if modes is None:
            return Realisation.of(self.A, self.B, self.C, self.feedthrough)
        blocks, V = modes
        B: Array = np.linalg.solve(V, self.B).astype(np.float64)
        return Realisation.of_blocks(blocks, B, self.C @ V, self.feedthrough)

    def filtered_realisation(self, taps: Array) -> Realisation:
        """Of F T, F the finite impulse response `taps`."""
        if len(taps) > 1:
            return Realisation.of(*filtered(self.A, self.B, self.C, self.feedthrough, taps))
        one = self.realisation
        return Realisation(one.A, one.first, one.B, taps[0] * one.C, taps[0] * one.D)

    def response(self, omega: ArrayLike) -> Complex:
        """Shape (M, p, m) at omega (M,) [rad/sample]."""
        z = np.atleast_1d(unit_circle(omega))
        return self._output @ self._resolvent(z) + self.feedthrough

    @cached_property
    def _schur(self) -> tuple[Complex, Complex]:
        from scipy.linalg import schur

        T, Z, *_ = schur(self.A, output="complex")
        return np.asarray(T), np.asarray(Z)

    @property
    def _output(self) -> Complex:
        return self.C @ self._schur[1]

    def _resolvent(self, z: Complex) -> Complex:
        """(z - T)^-1 Z^H B for the Schur form A = Z T Z^H, all z at once; (M, n, m)."""
        T, Z = self._schur
        right = Z.conj().T @ self.B
        X = np.empty((len(z), *right.shape), dtype=np.complex128)
        for i in range(len(T) - 1, -1, -1):
            above = np.tensordot(X[:, i + 1 :], T[i, i + 1 :], axes=(1, 0))
            X[:, i] = (right[i] + above) / (z - T[i, i])[:, None]
        return X


def matrices(
    A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike | None, dimensions: int
) -> tuple[Array, Array, Array, Array]:
    """Copies that are finite and fit each other; 3 dimensions: with an axis of time first.

    Raises ValueError.
    """
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


@dataclass(frozen=True, eq=False)
class TimeVarying(_OnRecords):
    """Matrices of each sample: A (N, n, n), B (N, n, m), C (N, p, n), D (N, p, m) or None for 0."""

    A: Array
    B: Array
    C: Array
    D: Array | None = None

    def __post_init__(self) -> None:
        for name, M in zip(
            "ABCD", matrices(self.A, self.B, self.C, self.D, dimensions=3), strict=True
        ):
            M.setflags(write=False)
            object.__setattr__(self, name, M)

    @property
    def n_samples(self) -> int:
        return len(self.A)

    @property
    def n_inputs(self) -> int:
        return self.B.shape[2]

    @property
    def n_outputs(self) -> int:
        return self.C.shape[1]

    @cached_property
    def realisation(self) -> Realisation:
        assert self.D is not None
        return Realisation.of(self.A, self.B, self.C, self.D)

    def filtered_realisation(self, taps: Array) -> Realisation:
        """Of F T, F the finite impulse response `taps`."""
        assert self.D is not None
        return Realisation.of(*filtered(self.A, self.B, self.C, self.D, taps))
