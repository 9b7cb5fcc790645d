"""Robustness of any law by sampled plants, with the confidence that the sample gives.

n plants drawn from an uncertainty say of the whole of it only how large a part converges, within
an interval: of 59 plants that all converge, at least 95 % of the uncertainty does with confidence
0.95. Clopper and Pearson, "The use of confidence or fiducial limits illustrated in the case of the
binomial" (1934); Tempo, Calafiore and Dabbene, "Randomized Algorithms for Analysis and Control of
Uncertain Systems", 2nd ed. (2013), section 8.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..laws.law import FirstOrderLaw
from ..models.system_matrix import AnyModel
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
