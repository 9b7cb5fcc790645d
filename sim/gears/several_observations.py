"""Learning of the transmission error from any of several observations, each scanned once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from operator import add

import numpy as np

from armside.arrays import Array

from .fit import chosen, fit, normal, softened
from .residual_spectra import Observation
from .scan import COARSE, Candidate, Scan, grids, peaks, refined, scan
from .transmission import Transmission

CANDIDATES = 8
"""Peaks of each joint's scan that are tried."""
CHANCE = 15.0
"""Energy that a term must explain, over the median of the scan: by chance one order in 30,000 of
white noise does (chi-squared of two degrees of freedom). On the AUBO 8 to 60 differ by 0.005."""
SHAM = (0.9, 1.1, 0.8, 1.2, 0.85, 1.15)
"""Factors on the orders found, tried in this order, for a control that must explain nothing."""


@dataclass(frozen=True, eq=False)
class Course:
    """Observations to learn from, and the resolution (n,) of their orders."""

    observations: Sequence[Observation]
    apart: Array
    largest_order: float
    per_joint: int
    """Most terms of one joint."""
    elastic: bool = False
    """Find the softness of the arm too."""
    step: Callable[[], None] = lambda: None
    """Called after each joint of each scan."""

    @cached_property
    def scans(self) -> list[Scan]:
        """Scan of each observation."""
        orders = grids(self.apart, self.largest_order)
        return [scan(one, orders, self.step) for one in self.observations]

    def total(self, lesson: Sequence[int]) -> Scan:
        """Sum of the scans of some observations."""
        return reduce(add, (self.scans[k] for k in lesson))

    def learn(self, lesson: Sequence[int]) -> tuple[Transmission | None, Transmission | None]:
        """Transmission error by some of the observations, and the fit of as many sham orders; None
        where no order stands out from chance."""
        total, own = self.total(lesson), [self.observations[k] for k in lesson]
        candidates = peaks(total, self.apart, CANDIDATES)
        equations = normal(own, candidates)
        taken = chosen(equations, candidates, CHANCE * total.typical, self.per_joint)
        if not taken:
            return None, None
        terms = self._refined(own, [candidates[k] for k in taken])
        return self._fit(own, terms), self._fit(own, sham(terms, self.apart))

    def _fit(self, own: list[Observation], terms: Sequence[Candidate]) -> Transmission:
        own = reweighted(own, terms)
        if not self.elastic:
            return fit(own, terms)
        own, softness, spread = softened(own, terms)
        return replace(fit(own, terms, spread), softness=softness)

    def _refined(self, own: list[Observation], terms: list[Candidate]) -> list[Candidate]:
        """Orders between those of the scan, each beside the terms that were found before."""
        x = normal(own, terms).solve().reshape(-1, 2)
        parts = [[one.columns(*t) @ c for t, c in zip(terms, x, strict=True)] for one in own]
        out: list[Candidate] = []
        for k, term in enumerate(terms):
            targets = [
                one.target - sum(part[:k] + part[k + 1 :], np.zeros(()))
                for one, part in zip(own, parts, strict=True)
            ]
            out.append(refined(own, targets, term, min(0.5 * COARSE, 0.5 * self.apart[term[0]])))
        return out


def reweighted(
    observations: Sequence[Observation], terms: Sequence[Candidate]
) -> list[Observation]:
    """The observations with the noise that a first fit of these terms leaves."""
    x = normal(observations, terms).solve().reshape(-1, 2)
    models = [
        sum((one.columns(*t) @ c for t, c in zip(terms, x, strict=True)), np.zeros(()))
        for one in observations
    ]
    return [one.reweighted(model) for one, model in zip(observations, models, strict=True)]


def sham(terms: Sequence[Candidate], apart: Array) -> list[Candidate]:
    """As many orders of the same joints, none of them near one that was found."""
    out: list[Candidate] = []
    for joint, order in terms:
        others = [found for of, found in [*terms, *out] if of == joint]
        away = {f: min(abs(f * order - other) for other in others) for f in SHAM}
        clear = [factor for factor in SHAM if away[factor] >= apart[joint]]
        out.append((joint, order * (clear[0] if clear else max(SHAM, key=lambda f: away[f]))))
    return out
