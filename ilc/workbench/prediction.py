"""Convergence that a model predicts for a law: criterion, lifted iteration, and each error."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from armside.arrays import Array

from ..analysis.eigenloci import Eigenloci, eigenloci
from ..analysis.lifted import LiftedIteration
from ..laws.heuristic import Heuristic
from ..laws.law import FirstOrder, Law
from ..models.system import System
from ..models.system_matrix import Model
from ..records import records
from .contraction import contraction
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
    return Prediction(contraction(built, T_u), _spectral_radius(built, setting, T_u), errors)


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


def _spectral_radius(law: Law, setting: Setting, T_u: Model) -> float | None:
    known = isinstance(law, (Heuristic, FirstOrder))
    if not known or setting.reference.size > MOST_LIFTED:
        return None
    return LiftedIteration.build(T_u, law, setting.n_samples, setting.n_columns).spectral_radius
