"""Choice of orders and least-squares fit of their amplitudes, from one or several recordings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from .observation import Observation, as_real
from .scan import Candidate
from .transmission import Transmission

RIDGE = 1e-2
"""Of the normal equations, relative to each column's energy: neighbouring orders of one joint are
hardly told apart. Of the trial on the AUBO (docs/real.md)."""
BLOCK = 2.0
"""[s] Stretches of time whose scores are taken as independent in the covariance."""


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations of one observation over candidates: X^T X, X^T y, y^T y."""

    gram: Array
    score: Array
    energy: float

    def __add__(self, other: "Normal") -> "Normal":
        gram, score = self.gram + other.gram, self.score + other.score
        return Normal(gram, score, self.energy + other.energy)

    def of(self, terms: Sequence[int]) -> "Normal":
        """Equations of some of the candidates."""
        pairs = [2 * k + i for k in terms for i in (0, 1)]
        return Normal(self.gram[np.ix_(pairs, pairs)], self.score[pairs], self.energy)

    def solve(self) -> Array:
        """Coefficients (2 P,), with the ridge."""
        return np.asarray(np.linalg.solve(self.gram + _ridge(self.gram), self.score), np.float64)

    def explained(self) -> float:
        """Energy that the solution explains."""
        x = self.solve()
        return float(2.0 * x @ self.score - x @ self.gram @ x)


def _ridge(gram: Array) -> Array:
    return RIDGE * np.diag(np.diag(gram)) + np.finfo(float).tiny * np.eye(len(gram))


def normal(one: Observation, candidates: Sequence[Candidate]) -> Normal:
    """Normal equations of an observation over all candidates."""
    X = np.concatenate([as_real(one.columns(*candidate)) for candidate in candidates], axis=1)
    X, y = X.astype(np.float64), as_real(one.target)
    return Normal(X.T @ X, X.T @ y, float(y @ y))


def chosen(
    equations: Normal, candidates: Sequence[Candidate], floor: Array, per_joint: int
) -> list[int]:
    """Candidates in the order in which they explain most beside those before them.

    Args:
        equations: sum over the recordings that are learned from.
        floor: (n,), energy that a candidate of each joint must explain.
        per_joint: most terms of one joint.
    """
    taken: list[int] = []
    while True:
        before = equations.of(taken).explained() if taken else 0.0
        gains = np.full(len(candidates), -np.inf)
        for k, (joint, _) in enumerate(candidates):
            of_joint = sum(candidates[t][0] == joint for t in taken)
            if k not in taken and of_joint < per_joint:
                gain = equations.of([*taken, k]).explained() - before
                gains[k] = gain if gain > floor[joint] else -np.inf
        best = int(np.argmax(gains))
        if gains[best] == -np.inf:
            return taken
        taken.append(best)


def fit(
    observations: Sequence[Observation], equations: Normal, terms: Sequence[Candidate]
) -> Transmission:
    """Transmission error with these terms; `equations` are those of the terms, summed."""
    x, bread = equations.solve(), np.linalg.inv(equations.gram + _ridge(equations.gram))
    meat = sum((_scores(one, terms, x) for one in observations), np.zeros_like(bread))
    return Transmission(
        joints=tuple(joint for joint, _ in terms),
        orders=np.array([order for _, order in terms]),
        coefficients=x.reshape(-1, 2),
        covariance=bread @ meat @ bread,
    )


def _scores(one: Observation, terms: Sequence[Candidate], x: Array) -> Array:
    """Sum of the outer products of the scores of stretches of time, which vary in noise.

    (2 P, 2 P). Vibration comes and goes with the motion, so frequencies are not independent.
    """
    X = np.concatenate([one.columns(*term) for term in terms], axis=2)
    residual = one.in_time(one.target - X @ x)
    length = int(BLOCK * one.sampling)
    starts = np.arange(0, len(residual), length)
    scores = np.zeros((len(starts), len(x)))
    for k in range(len(x)):
        product = (one.in_time(X[:, :, k]) * residual).sum(axis=1)
        scores[:, k] = np.add.reduceat(product, starts)
    # as_real counts each bin once, a real signal twice, over the number of samples
    scores *= len(residual) / 2.0
    return scores.T @ scores
