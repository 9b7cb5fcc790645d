"""Corrections that are linear in a few parameters: learned on one reference, used on any other.

    u = Psi(r) theta        theta_{k+1} = arg min ||e_k - T_u Psi (theta - theta_k)||^2
                                                  + rho ||theta - theta_k||^2

Psi holds functions of the reference r: its derivatives (van der Meulen, Tousain and Bosgra, "Fixed
structure feedforward controller design exploiting iterative trials", 2008; van de Wijdeven and
Bosgra, "Using basis functions in iterative learning control", 2010) and hysteresis operators
(`models.hysteresis`), which friction needs. theta describes the plant, not the task.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from ..models.system import System
from ..models.system_matrix import AnyModel, check_inputs, check_model
from ..records import as_real, as_record, records
from .law import FirstOrderLaw


@records("reference")
def derivatives(reference: Array, sample_time: float, order: int = 4) -> Array:
    """(N, n, order): derivatives 1 .. order of each column, central differences [1/s]."""
    if order < 1:
        raise ValueError(f"order must be >= 1, got {order}")
    found, last = [], reference
    for _ in range(order):
        last = np.gradient(last, sample_time, axis=0)
        found.append(last)
    return np.stack(found, axis=2)


def led(basis: Array, leads: Sequence[int]) -> Array:
    """(N, n, p m): functions (N, n, p) that come `leads` samples earlier, each of m leads."""
    rows = [np.clip(np.arange(len(basis)) + lead, 0, len(basis) - 1) for lead in leads]
    return np.concatenate([basis[row] for row in rows], axis=2)


def across(basis: Array) -> Array:
    """(N, n, n p): every column has the functions of all columns, for a coupled plant."""
    n_samples, n, p = basis.shape
    return np.repeat(basis.reshape(n_samples, 1, n * p), n, axis=1)


def correction_of(basis: Array, parameters: Array) -> Array:
    """u = Psi theta, (N, n), of a basis (N, n, p) and parameters (n, p)."""
    return np.einsum("tnp,np->tn", basis, parameters)


def fitted(bases: Sequence[Array], corrections: Sequence[Array], ridge: float = 1e-6) -> Array:
    """Parameters (n, p) nearest to learned corrections (N, n) of several references together.

    ridge: relative to the mean square of each function. Functions that are zero get none.
    """
    if len(bases) != len(corrections) or not bases:
        raise ValueError(f"{len(bases)} bases and {len(corrections)} corrections are no pairs")
    if not (np.isfinite(ridge) and ridge > 0.0):
        raise ValueError(f"ridge must be > 0, got {ridge}")
    learned = [as_record(u, "a correction") for u in corrections]
    Psi, u = np.concatenate(list(bases)), np.concatenate(learned)
    return np.stack([_ridge(Psi[:, j], u[:, j], ridge) for j in range(u.shape[1])])


def _ridge(A: Array, b: Array, ridge: float) -> Array:
    size = np.sqrt(np.square(A).mean(axis=0))
    size[size == 0.0] = np.inf
    Z = A / size
    normal = Z.T @ Z + ridge * len(Z) * np.eye(Z.shape[1])
    return np.linalg.solve(normal, Z.T @ b) / size


@dataclass(frozen=True, kw_only=True, eq=False)
class BasisFunctions(FirstOrderLaw):
    """Norm-optimal law within a basis; a correction outside it is projected onto it."""

    T_u: AnyModel
    basis: Array
    """(N, n, p): p functions of each column."""
    ridge: float = 1e-9
    """rho, relative to the mean square of each function's response."""

    def __post_init__(self) -> None:
        check_model(self.T_u)
        basis = as_real(self.basis, "basis")
        if basis.ndim != 3 or 0 in basis.shape or not np.isfinite(basis).all():
            raise ValueError(f"basis must be finite, of shape (N, n, p), got {basis.shape}")
        if not (np.isfinite(self.ridge) and self.ridge > 0.0):
            raise ValueError(f"ridge must be > 0, got {self.ridge}")
        check_inputs(self.T_u, basis.shape[1])
        object.__setattr__(self, "basis", basis)
        object.__setattr__(self, "_response", self._responses())

    _response: Array = field(init=False, repr=False)

    def _responses(self) -> Array:
        """(N q, n p): the q outputs for each parameter, one at a time."""
        n_samples, n, p = self.basis.shape
        n_outputs = n if isinstance(self.T_u, System) else self.T_u.n_outputs
        found = np.empty((n_samples * n_outputs, n, p))
        for j in range(n):
            for i in range(p):
                alone = np.zeros((n_samples, n))
                alone[:, j] = self.basis[:, j, i]
                found[:, j, i] = self.T_u.simulate(alone).ravel()
        return found.reshape(len(found), n * p)

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n_samples, n_columns) != self.basis.shape[:2]:
            needed = f"basis is for records of shape {self.basis.shape[:2]}"
            raise ValueError(f"{needed}, the record has {(n_samples, n_columns)}")

    @records("correction")
    def parameters(self, correction: Array) -> Array:
        """(n, p) of a correction (N, n), nearest to it."""
        return fitted([self.basis], [correction], 1e-12)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        if error.size != len(self._response):
            needed = (len(self.basis), len(self._response) // len(self.basis))
            raise ValueError(f"error must have shape {needed}, got {error.shape}")
        change = _ridge(self._response, error.ravel(), self.ridge).reshape(self.basis.shape[1:])
        return correction_of(self.basis, self.parameters(correction) + change)
