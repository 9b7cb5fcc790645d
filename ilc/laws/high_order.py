"""High-order law: corrections and errors of several past iterations."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex
from ..records import records
from .law import FilteredLaw

Pair = tuple[Array, Array]
"""(u, e) of one iteration."""


@dataclass(frozen=True, kw_only=True)
class HighOrder(FilteredLaw):
    """u_{k+1} = Q sum_i (alpha_i u_{k-i} + beta_i L e_{k-i}), i = 0 .. p - 1. Thesis 7.3.

    u and e before iteration 0 are zero. The weights alpha and beta are equally many, newest first.
    """

    alpha: tuple[float, ...]
    beta: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.alpha or len(self.alpha) != len(self.beta):
            given = f"got {len(self.alpha)} and {len(self.beta)}"
            raise ValueError(f"alpha and beta must be equally many, at least 1, {given}")
        if not np.isfinite(self.alpha + self.beta).all():
            raise ValueError(f"alpha and beta must be finite, got {self.alpha} and {self.beta}")

    @property
    def order(self) -> int:
        return len(self.alpha)

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: tuple[Pair, ...] | None = None, /
    ) -> tuple[Array, tuple[Pair, ...]]:
        pairs = ((correction, error), *(memory or ()))[: self.order]
        total, learned = np.zeros_like(correction), np.zeros_like(error)
        for alpha, beta, (u, e) in zip(self.alpha, self.beta, pairs, strict=False):
            total += alpha * u
            learned += beta * e
        return self.Q(total + self.L(learned)), pairs[: self.order - 1]

    def spectral_radius(self, T_u: Complex, omega: ArrayLike) -> Array:
        """Spectral radius of the iteration at each frequency; below 1 it converges."""
        L, Q = self.L.response(omega), self.Q.response(omega)
        # U_{k+1} = sum_i Q (alpha_i - beta_i T_u L) U_{k-i} + (terms of e_0), in companion form.
        companion = np.zeros((np.size(omega), self.order, self.order), dtype=complex)
        for i, (alpha, beta) in enumerate(zip(self.alpha, self.beta, strict=True)):
            companion[:, 0, i] = Q * (alpha - beta * T_u * L)
        companion[:, 1:, :-1] += np.eye(self.order - 1)
        return np.abs(np.linalg.eigvals(companion)).max(axis=-1)
