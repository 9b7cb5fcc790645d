"""Scores of entries on the same tasks: intervals, significance, and ranks that share.

Everything is done on the logarithm of what is left, paired by task.
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

EXACT = 12
"""Most tasks for which all signs are tried."""
DRAWS = 20_000
LEVEL = 0.05
"""Of significance, of all pairs of a track together."""


class Standing(NamedTuple):
    """An entry in its track."""

    name: str
    rank: int
    """One more than the entries that are significantly better."""
    score: float
    low: float
    high: float
    """Geometric mean of what is left, and its interval of 95 %."""


def interval(logs: Array, confidence: float = 0.95) -> tuple[float, float]:
    """Bootstrap interval of the geometric mean, of logarithms (n,)."""
    rng, n = np.random.default_rng(0), len(logs)
    means = logs[rng.integers(n, size=(4000, n))].mean(axis=1)
    low, high = np.exp(np.quantile(means, (0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence)))
    return float(low), float(high)


def permutation(one: Array, other: Array) -> float:
    """Two-sided p that the signs of paired differences (n,) are by chance: of all signs up to EXACT
    tasks, else of DRAWS random ones and the observed ones."""
    difference = one - other
    n, seen = len(difference), abs(difference.sum())
    if n <= EXACT:
        signs = np.array(list(product((-1.0, 1.0), repeat=n)))
        return float(np.mean(np.abs(signs @ difference) >= seen * (1.0 - 1e-12)))
    signs = np.random.default_rng(0).choice((-1.0, 1.0), size=(DRAWS, n))
    more = np.count_nonzero(np.abs(signs @ difference) >= seen * (1.0 - 1e-12))
    return float((1 + more) / (1 + DRAWS))


def holm(p: Sequence[float]) -> list[float]:
    """p adjusted for that many comparisons, after Holm (1979)."""
    order = np.argsort(p, kind="stable")
    stepped = np.array(p)[order] * (len(p) - np.arange(len(p)))
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(np.maximum.accumulate(stepped), 1.0)
    return adjusted.tolist()


def significant(logs: dict[str, Array]) -> dict[tuple[str, str], float]:
    """Adjusted p of each pair, the better entry first."""
    names = sorted(logs, key=lambda name: float(logs[name].mean()))
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    return dict(zip(pairs, holm([permutation(logs[a], logs[b]) for a, b in pairs]), strict=True))


def standings(left: dict[str, Array]) -> list[Standing]:
    """Entries by their score, of what each leaves in the same tasks (n,)."""
    logs = {name: np.log(each) for name, each in left.items()}
    p = significant(logs)
    found = list[Standing]()
    for name in sorted(logs, key=lambda name: float(logs[name].mean())):
        better = sum(b == name and value < LEVEL for (_, b), value in p.items())
        score = float(np.exp(logs[name].mean()))
        found.append(Standing(name, 1 + better, score, *interval(logs[name])))
    return found
