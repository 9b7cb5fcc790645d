"""Criterion (7.5) of the laws of a comparison: sup ||Q (I - L T_u)||_2 on infinite records.

The frequencies are refined at the poles of T_u and Q, and at the zeros of the model of the law:
where they are near the unit circle its inverse is steep.
"""

import numpy as np

from armside.arrays import Array

from ..analysis.criterion import frequency_grid, heuristic_criterion
from ..laws.heuristic import Heuristic
from ..laws.law import FirstOrder, Law
from ..laws.norm_optimal import NormOptimal
from ..models.conversion import as_state_space
from ..models.peak import peak
from ..models.state_space import StateSpace
from ..models.system import Complex, System
from ..models.system_matrix import Model, SystemMatrix

_FINITE = 1e8  # generalised eigenvalues above it are zeros at infinity


def contraction(law: Law, T_u: Model) -> float | None:
    """Contraction of the correction by first-order laws with known responses; None for others."""
    if isinstance(law, Heuristic):
        return heuristic_criterion(T_u, law.gamma, law.delta, law.Q).contraction
    if isinstance(law, FirstOrder):
        inverted, poles = getattr(law.L, "T_u", None), getattr(law.Q, "poles", np.zeros(0))
    elif isinstance(law, NormOptimal) and hasattr(law.T_u, "response"):
        inverted, poles = law.T_u, np.zeros(0)
    else:
        return None

    def power(omega: Array) -> Array:
        found = _iteration(law, T_u.response(omega), omega)
        return np.square(np.linalg.norm(found, ord=2, axis=(1, 2)))

    every = np.concatenate((T_u.all_poles, _poles_and_zeros(inverted), poles))
    found = peak(power, every.astype(np.complex128), frequency_grid())
    return float(np.sqrt(found.values.max()))


def _iteration(law: FirstOrder | NormOptimal, T: Complex, omega: Array) -> Complex:
    """Q (I - L T_u), (M, m, m); (M, 1, 1) for one system, which each motor is then."""
    T = T[:, None, None] if T.ndim == 1 else T
    m = T.shape[2]
    if isinstance(law, NormOptimal):
        Q, L = law.responses(omega)
    else:
        Q, L = law.Q.response(omega), law.L.response(omega)
    return _matrices(Q, m) @ (np.eye(m) - _matrices(L, m) @ T)


def _matrices(response: Array | Complex, m: int) -> Complex:
    """Response (M,), of each motor (M, m), or (M, m, p), as the last."""
    if response.ndim == 3:
        return response.astype(np.complex128)
    columns = response[:, None] if response.ndim == 1 else response
    return (columns[:, :, None] * np.eye(m)).astype(np.complex128)


def _poles_and_zeros(T: object) -> Complex:
    """Twice the poles and zeros of a model, of which L has the squared size; zeros outside the unit
    circle reflected. None of what has no states, and no zeros of models that are not square."""
    if isinstance(T, System):
        poles, zeros = T.all_poles, np.roots(np.trim_zeros(T.b))
    elif isinstance(T, SystemMatrix | StateSpace):
        poles, zeros = T.all_poles, _transmission_zeros(as_state_space(T))
    else:
        return np.zeros(0, dtype=np.complex128)
    outside = np.abs(zeros) > 1.0
    zeros = np.where(outside, 1.0 / np.where(outside, zeros, 1.0).conj(), zeros)
    return np.tile(np.concatenate((poles, zeros)), 2).astype(np.complex128)


def _transmission_zeros(T: StateSpace) -> Complex:
    """Where [[A - z I, B], [C, D]] loses rank."""
    from scipy.linalg import eigvals

    n, m = T.B.shape
    if len(T.C) != m:
        return np.zeros(0, dtype=np.complex128)
    system = np.block([[T.A, T.B], [T.C, T.feedthrough]])
    shift = np.zeros_like(system)
    shift[:n, :n] = np.eye(n)
    with np.errstate(divide="ignore", invalid="ignore"):
        zeros = np.asarray(eigvals(system, shift), dtype=np.complex128)
    return zeros[np.isfinite(zeros) & (np.abs(zeros) < _FINITE)]
