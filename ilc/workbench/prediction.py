"""Convergence that a model predicts for a law: criterion, lifted iteration, and each error."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from armside.arrays import Array

from ..analysis.criterion import criterion, frequency_grid, heuristic_criterion
from ..analysis.eigenloci import Eigenloci, eigenloci
from ..analysis.lifted import LiftedIteration
from ..laws.heuristic import Heuristic
from ..laws.law import FirstOrder, Law
from ..laws.norm_optimal import NormOptimal
from ..models.peak import peak
from ..models.system import Complex, System
from ..models.system_matrix import Model
from ..records import records
from .laws import MEASURING, build_law
from .setting import Setting
from .words import Words

MOST_LIFTED = 400
"""Numbers of a record up to which its matrices are built: a second."""
LARGEST = 1e30
"""Predicted error relative to the first at which a prediction of divergence ends."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Predicted convergence of one law; None where it is not known."""

    contraction: float | None
    """sup |Q (1 - L T_u)| on infinite records: below 1 ||e_k - e_inf|| shrinks to it or less."""
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
    return Prediction(_contraction(built, T_u), _spectral_radius(built, setting, T_u), errors)


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


def _contraction(law: Law, T_u: Model) -> float | None:
    """Criterion (7.5) for first-order laws with known responses.

    Refined at the poles of T_u and Q, and at the zeros of the model of the law: where they are near
    the unit circle its inverse is steep.
    """
    if isinstance(law, Heuristic):
        return heuristic_criterion(T_u, law.gamma, law.delta, law.Q).contraction
    if not isinstance(T_u, System):
        return None
    if isinstance(law, NormOptimal) and isinstance(law.T_u, System):
        designed = law

        def responses(omega: Array) -> tuple[Complex, Complex]:
            return designed.responses(omega)

        inverted, poles = law.T_u, np.zeros(0, dtype=np.complex128)
    elif isinstance(law, FirstOrder):
        L, Q = law.L, law.Q

        def responses(omega: Array) -> tuple[Complex, Complex]:
            return Q.response(omega).astype(np.complex128), L.response(omega)

        inverted, poles = getattr(L, "T_u", T_u), getattr(Q, "poles", np.zeros(0))
    else:
        return None

    def power(omega: Array) -> Array:
        q, learning = responses(omega)
        found = criterion(T_u.response(omega), learning, np.abs(q), omega)
        return np.square(found.q * found.learning)

    turns = _poles_and_zeros(inverted) if isinstance(inverted, System) else T_u.all_poles
    every = np.concatenate((T_u.all_poles, turns, poles)).astype(np.complex128)
    return float(np.sqrt(peak(power, every, frequency_grid()).values.max()))


def _poles_and_zeros(T: System) -> Complex:
    """Twice the poles and zeros of a model, of which L has the squared size; zeros outside the unit
    circle reflected."""
    zeros = np.roots(np.trim_zeros(T.b))
    outside = np.abs(zeros) > 1.0
    zeros = np.where(outside, 1.0 / np.where(outside, zeros, 1.0).conj(), zeros)
    return np.tile(np.concatenate((T.all_poles, zeros)), 2).astype(np.complex128)


def _spectral_radius(law: Law, setting: Setting, T_u: Model) -> float | None:
    known = isinstance(law, (Heuristic, FirstOrder))
    if not known or setting.reference.size > MOST_LIFTED:
        return None
    return LiftedIteration.build(T_u, law, setting.n_samples, setting.n_columns).spectral_radius
