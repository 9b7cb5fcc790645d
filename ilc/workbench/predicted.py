"""Convergence that a model predicts for a law: criterion, lifted iteration, and each error.

The criterion is (7.5), sup ||Q (I - L T_u)||_2 on infinite records. Its frequencies are refined
at the poles of T_u and Q, and at the zeros of the model of the law: where they are near the unit
circle its inverse is steep.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from armside.arrays import Array

from ..analysis.criterion import as_matrices, frequency_grid, heuristic_criterion
from ..analysis.eigenloci import Eigenloci, eigenloci
from ..analysis.record_iteration import LiftedIteration
from ..laws.first_order import FirstOrder, Law
from ..laws.heuristic import Heuristic
from ..laws.norm_optimal import NormOptimal
from ..models.conversion import as_state_space
from ..models.peak import peak
from ..models.state_space import StateSpace
from ..models.system import Complex, System
from ..models.system_matrix import Model, SystemMatrix
from ..records import records
from .laws import MEASURING, build_law
from .task import Setting
from .words import Words

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
    return as_matrices(Q, m) @ (np.eye(m) - as_matrices(L, m) @ T)


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


MOST_LIFTED = 400
"""Numbers of a record up to which its matrices are built: a second."""
LARGEST = 1e30
"""Predicted error relative to the first at which a prediction of divergence ends."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Predicted convergence of one law; None where it is not known."""

    contraction: float | None
    """sup |Q (1 - L T_u)| on infinite records: below 1 ||u_k - u_inf|| shrinks to it or less; for
    several motors sup ||Q (I - L T_u)||_2."""
    spectral_radius: float | None
    """Of the lifted iteration on the finite record: below 1 it converges in the end."""
    errors: Array
    """(K + 1,) predicted ||e_k||, from the measured e_0 and without further noise."""


@records("first_error", "first_correction")
def predict(
    law: str,
    setting: Setting,
    first_error: Array,
    iterations: int,
    *,
    first_correction: Array,
    memory: Any = None,
) -> Prediction:
    """Prediction of the law with the setting's model.

    first_error: e_0, shape (N, n), measured with first_correction u_0. memory: of the law before
    its first update. The errors follow e_k = e_0 - T_u (u_k - u_0), the lifted iteration.
    """
    T_u = setting.T_u("a prediction")

    def error_of(correction: Array) -> Array:
        return first_error - T_u.simulate(correction - first_correction)

    def simulated(correction: Array) -> Array:
        return setting.reference - first_error + T_u.simulate(correction - first_correction)

    built = build_law(law, replace(setting, experiment=simulated))
    errors = _errors(built, error_of, first_correction, memory, iterations)
    if Words.parse(law).name in MEASURING:  # L is measured, not stated
        return Prediction(None, None, errors)
    radius = None
    if isinstance(built, (Heuristic, FirstOrder)) and setting.reference.size <= MOST_LIFTED:
        shape = setting.n_samples, setting.n_columns
        radius = LiftedIteration.build(T_u, built, *shape).spectral_radius
    return Prediction(contraction(built, T_u), radius, errors)


def predicted_loci(law: str, setting: Setting) -> Eigenloci | None:
    """Eigenloci of a heuristic law with the coupled model of the setting; None for others."""
    built = build_law(law, setting)
    if not isinstance(built, Heuristic) or setting.model is None:
        return None
    coupled = not isinstance(setting.model, System)
    return eigenloci(setting.model, built.gamma, built.delta, built.Q) if coupled else None


def _errors(
    law: Law, error_of: Callable[[Array], Array], correction: Array, memory: Any, iterations: int
) -> Array:
    errors = [first_error := error_of(correction)]
    for _ in range(iterations):
        if not np.abs(errors[-1]).max() < LARGEST * max(np.abs(first_error).max(), 1e-300):
            break
        correction, memory = law.step(correction, errors[-1], memory)
        errors.append(error_of(correction))
    norms = np.full(iterations + 1, np.nan)
    norms[: len(errors)] = [np.linalg.norm(error) for error in errors]
    return norms
