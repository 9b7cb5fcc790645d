"""Checks over many seeds, and intervals of a mean."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from armside.sim.evaluation.check import Check
from armside.sim.tuning.objective import mean_interval as mean_interval


def held(by_seed: Mapping[int, Sequence[Check]], fraction: float = 1.0) -> list[Check]:
    """Checks that each check holds for at least a fraction of the seeds, all in the same order."""
    n = len(by_seed)
    rule = "every seed" if fraction == 1.0 else f"at least {100 * fraction:.0f} % of the seeds"
    found = []
    for first, *others in zip(*by_seed.values(), strict=True):
        holding = sum(check.holds for check in (first, *others))
        words = f"{first.id}: {first.statement}: {first.band}, for {rule} ({holding} of {n})"
        found.append(Check(first.id, words, first.thesis, holding, low=math.ceil(fraction * n)))
    return found


def bootstrap(values: np.ndarray, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the mean of values (n,) by resampling; of paired differences, say."""
    rng, n = np.random.default_rng(0), len(values)
    means = values[rng.integers(n, size=(4000, n))].mean(axis=1)
    low, high = np.quantile(means, (0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence))
    return float(low), float(high)
