"""Robustness of a design: by sampled plants, and to the parameters of the two-mass joint.

n plants drawn from an uncertainty say of the whole of it only how large a part converges, within
an interval: of 59 plants that all converge, at least 95 % of the uncertainty does with confidence
0.95. Clopper and Pearson, "The use of confidence or fiducial limits illustrated in the case of
the binomial" (1934); Tempo, Calafiore and Dabbene, "Randomized Algorithms for Analysis and
Control of Uncertain Systems", 2nd ed. (2013), section 8.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import as_tuple
from ..laws.first_order import FirstOrderLaw
from ..laws.heuristic import Heuristic
from ..models.system_matrix import AnyModel
from ..models.two_mass import TwoMassLoop
from .criterion import heuristic_criterion
from .record_iteration import RecordIteration


@dataclass(frozen=True, eq=False)
class SampledRobustness:
    """Contraction (n,) of the law with each sampled plant: monotone convergence below 1."""

    contraction: Array

    @property
    def fraction(self) -> float:
        """Fraction of the samples with which the iteration converges monotonically."""
        return float((self.contraction < 1.0).mean())

    def at_least(self, confidence: float = 0.95) -> float:
        """Fraction of the uncertainty with which it does, from below, one-sided."""
        held = int((self.contraction < 1.0).sum())
        return fraction_interval(held, len(self.contraction), 2.0 * confidence - 1.0)[0]


def sampled_robustness(
    plants: Iterable[AnyModel], law: FirstOrderLaw, n_samples: int, n_columns: int = 1
) -> SampledRobustness:
    """Contraction on records (n_samples, n_columns) with independent draws of the plant.

    Raises ValueError without plants, or for one that does not fit the law.
    """
    found = [RecordIteration(T, law, n_samples, n_columns).contraction for T in plants]
    if not found:
        raise ValueError("plants must not be empty")
    return SampledRobustness(np.array(found))


def fraction_interval(held: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Clopper-Pearson interval of a fraction, from `held` of n independent samples.

    It covers the fraction with at least that confidence, whatever n and the fraction are.
    """
    from scipy.special import betaincinv

    if not 0 <= held <= n or n < 1:
        raise ValueError(f"held must be 0 to n and n >= 1, got {held} of {n}")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence must be in (0, 1), got {confidence:g}")
    tail = 0.5 * (1.0 - confidence)
    low = 0.0 if held == 0 else float(betaincinv(held, n - held + 1, tail))
    high = 1.0 if held == n else float(betaincinv(held + 1, n - held, 1.0 - tail))
    return low, high


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
