"""Choice of orders and least-squares fit of their amplitudes, from one or several recordings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add

import numpy as np

from armside.arrays import Array

from .residual_spectra import Observation, Spectrum, as_real
from .scan import Candidate, smallest
from .transmission import Transmission

RIDGE = 1e-2
"""Of the normal equations, relative to each column's energy: neighbouring orders of one joint are
hardly told apart. Of the trial on the AUBO (docs/real.md)."""
BLOCK = 2.0
"""[s] Stretches of time whose scores are taken as independent in the covariance."""


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations over candidates: X^T X, X^T y, y^T y."""

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

    def refined(self) -> Array:
        """Coefficients (2 P,), solved twice: the ridge then takes nothing off what is well told."""
        x = self.solve()
        return x + replace(self, score=self.score - self.gram @ x).solve()

    def explained(self) -> float:
        """Energy that the solution explains."""
        x = self.solve()
        return float(2.0 * x @ self.score - x @ self.gram @ x)


def _ridge(gram: Array) -> Array:
    return RIDGE * np.diag(np.diag(gram)) + np.finfo(float).tiny * np.eye(len(gram))


def normal(observations: Sequence[Observation], candidates: Sequence[Candidate]) -> Normal:
    """Normal equations over all candidates, summed over the observations."""

    def of(one: Observation) -> Normal:
        X = np.concatenate([as_real(one.columns(*candidate)) for candidate in candidates], axis=1)
        X, y = X.astype(np.float64), as_real(one.target)
        return Normal(X.T @ X, X.T @ y, float(y @ y))

    return reduce(add, map(of, observations))


def chosen(
    equations: Normal, candidates: Sequence[Candidate], floor: Array, per_joint: int
) -> list[int]:
    """Candidates in the order in which they explain most beside those before them.

    floor: (n,), energy that a candidate of each joint must explain, of which `per_joint` at most
    are taken.
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
    observations: Sequence[Observation], terms: Sequence[Candidate], softness_spread: float = np.inf
) -> Transmission:
    """Transmission error with these terms.

    Its covariance is that of amplitudes, phases and orders found together, and of the softness of
    the arm where that was found too, which varies between joints by `softness_spread` [s^2].
    """
    x = normal(observations, terms).refined().reshape(-1, 2)
    gram, meat = np.zeros((2, 1, 1))
    for one in observations:
        X = _with_slopes(one, terms, x)
        residual = one.target - X[:, :, : x.size] @ x.ravel()
        real = as_real(X).astype(np.float64)
        gram, meat = gram + real.T @ real, meat + _scores(one, X, residual)
    n, prior = x.size, np.zeros(len(gram))
    prior[n + len(terms) :] = 0.5 / softness_spread**2  # softnesses follow coefficients and orders
    bread = np.linalg.inv(gram + _ridge(gram) + np.diag(prior))
    covariance = bread @ meat @ bread
    orders = covariance[n : n + len(terms), n : n + len(terms)]
    return Transmission(
        joints=tuple(joint for joint, _ in terms),
        orders=np.array([order for _, order in terms]),
        coefficients=x,
        covariance=covariance[:n, :n],
        order_deviations=np.sqrt(np.diag(orders)),
    )


def _with_slopes(one: Observation, terms: Sequence[Candidate], x: Array) -> Spectrum:
    """Columns of the terms, then what changes with their orders and with each joint's softness."""
    columns = [one.columns(*term) for term in terms]
    slopes = [one.order_slope(*term, c) for term, c in zip(terms, x, strict=True)]
    if one.softness is not None:
        seen: dict[int, Spectrum] = {}
        for (joint, _), pair, c in zip(terms, columns, x, strict=True):
            seen[joint] = seen.get(joint, 0.0) + pair @ c
        slopes += [one.softness_slope(joint, own) for joint, own in seen.items()]
    return np.concatenate([*columns, np.stack(slopes, axis=2)], axis=2)


def _scores(one: Observation, X: Spectrum, residual: Spectrum) -> Array:
    """(m, m), sum of the outer products of the scores of stretches of time: vibration comes and
    goes with the motion, so frequencies are not independent."""
    left = one.in_time(residual)
    starts = np.arange(0, len(left), int(BLOCK * one.sampling))
    scores = np.zeros((len(starts), X.shape[2]))
    for k in range(X.shape[2]):
        product = (one.in_time(X[:, :, k]) * left).sum(axis=1)
        scores[:, k] = np.add.reduceat(product, starts)
    # as_real counts each bin once, a real signal twice, over the number of samples
    scores *= len(left) / 2.0
    freedom = len(starts) / max(1, len(starts) - scores.shape[1])
    return freedom * scores.T @ scores


NEAREST = 1.2
"""Lowest resonance that is looked for, over the end of the band: nearer ones damping would bound,
which is left out."""
SPREAD = 0.3
"""Standard deviation between joints, over the largest softness that is looked for: that of axes 1
to 3 of the large robot by its tracker, whose resonances are 4.5, 6.5 and 10 Hz (seeds 101, 103)."""


def softened(
    observations: Sequence[Observation], terms: Sequence[Candidate]
) -> tuple[list[Observation], Array, float]:
    """The observations with the softness (n,) [s^2] of each joint, which is returned too.

    Below its first resonance an arm amplifies an error of joint j by 1 / (1 - softness_j f^2).
    Without a model of its structure, softness_j is what makes the joint's terms explain most, held
    to the softness that all joints have in common as far as the recordings leave it open.

    Joints without terms have that of all. The third is its standard deviation between joints.
    """
    n = observations[0].phi.shape[1]
    largest = float((NEAREST * max(one.band[1] for one in observations)) ** -2)
    spread = SPREAD * largest

    def explained(softness: Array) -> float:
        return normal([replace(one, softness=softness) for one in observations], terms).explained()

    bounds = 0.0, largest, 0.01 * largest
    common = smallest(lambda p: -explained(np.full(n, p)), *bounds)
    softness = np.full(n, common)
    for joint in sorted({joint for joint, _ in terms}):

        def missed(p: float, joint: int = joint) -> float:
            tried = softness.copy()
            tried[joint] = p
            # Energies are sums of |r|^2 of complex bins: minus the logarithm of the likelihood.
            return 0.5 * ((p - common) / spread) ** 2 - explained(tried)

        softness[joint] = smallest(missed, *bounds)
    return [replace(one, softness=softness) for one in observations], softness, spread
