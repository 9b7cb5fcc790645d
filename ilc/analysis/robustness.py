"""Robustness of a design to the parameters of the two-mass joint."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import as_tuple
from ..laws.heuristic import Heuristic
from ..models.two_mass import TwoMassLoop
from .criterion import heuristic_criterion

PARAMETERS = ("k", "d", "Ja", "Jm", "fm", "kt")
"""Uncertain parameters of `TwoMassJoint`; the gear ratio is exact."""


def contraction(loop: TwoMassLoop, law: Heuristic) -> float:
    """sup |Q| |1 - L T_u| on the motor side; infinity if the feedback loop itself is unstable."""
    (gamma,), (delta,) = as_tuple(law.gamma), as_tuple(law.delta)
    try:
        return heuristic_criterion(loop.T_motor, gamma, int(delta), law.Q).contraction
    except ValueError:
        return np.inf


def contraction_map(
    loop: TwoMassLoop, law: Heuristic, first: tuple[str, ArrayLike], second: tuple[str, ArrayLike]
) -> Array:
    """Contraction over two parameters of the actual joint, each a name and factors on it.

    Shape (factors of the first, factors of the second).
    """

    def at(factor_1: float, factor_2: float) -> float:
        return contraction(_scaled(loop, {first[0]: factor_1, second[0]: factor_2}), law)

    rows, columns = (np.asarray(factors, dtype=np.float64) for _, factors in (first, second))
    return np.array([[at(row, column) for column in columns] for row in rows])


@dataclass(frozen=True, eq=False)
class MonteCarlo:
    """Contraction (n,) of each sampled joint, and its factors on `PARAMETERS`, a row each."""

    contraction: Array
    factors: Array

    @property
    def fraction_converging(self) -> float:
        return float((self.contraction < 1.0).mean())

    def most_harmful(self) -> str:
        """Parameter whose deviation has the largest rank correlation with the contraction."""
        order = np.argsort(np.argsort(self.contraction))
        deviations = np.abs(np.log(self.factors))
        return PARAMETERS[int(np.argmax(np.abs(np.corrcoef(deviations.T, order)[-1, :-1])))]


def monte_carlo(
    loop: TwoMassLoop, law: Heuristic, spread: float, n: int, rng: np.random.Generator
) -> MonteCarlo:
    """n joints with every parameter multiplied by exp(uniform(-s, s)), s = log(1 + spread)."""
    if not spread > 0.0 or n < 1:
        raise ValueError(f"spread must be > 0 and n >= 1, got {spread} and {n}")
    width = np.log1p(spread)
    factors = np.exp(rng.uniform(-width, width, (n, len(PARAMETERS))))
    loops = (_scaled(loop, dict(zip(PARAMETERS, row, strict=True))) for row in factors)
    return MonteCarlo(np.array([contraction(each, law) for each in loops]), factors)


def _scaled(loop: TwoMassLoop, factors: dict[str, float]) -> TwoMassLoop:
    """Loop around another joint; controller and reference filter stay as designed."""
    for name in factors:
        if name not in PARAMETERS:
            raise ValueError(f"Unknown parameter {name!r}. Parameters: {', '.join(PARAMETERS)}")
    joint = loop.joint
    other = replace(joint, **{name: getattr(joint, name) * f for name, f in factors.items()})
    return replace(loop, joint=other, reference_model=loop.reference_model or joint)
