"""Cholesky factor of a quadratic criterion with a lifted matrix."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import recursion
from ..models.lifted_model import LiftedModel


@dataclass(frozen=True, eq=False)
class LiftedFactor:
    """Factor of H = T' F' We F T + R, for records (N, m)."""

    cholesky: tuple[Array, bool]

    @classmethod
    def build(cls, model: LiftedModel, taps: Array, We: Array, R: Array) -> "LiftedFactor":
        """Raises ValueError if H is singular: some correction has neither effect nor weight."""
        from scipy.linalg import cho_factor

        G = recursion(taps, np.ones(1), model.T.reshape(len(We), -1)).reshape(model.T.shape)
        try:
            H = G.T @ (We.reshape(-1, 1) * G) + np.diag(R.ravel())
            return cls(cho_factor(H, lower=True))
        except np.linalg.LinAlgError:
            remedy = "raise the weight of the correction or of its change"
            raise ValueError(f"the criterion does not determine the correction: {remedy}") from None

    def solve(self, g: Array) -> Array:
        """d with H d = g, (N, m) each."""
        from scipy.linalg import cho_solve

        return cho_solve(self.cholesky, g.ravel()).reshape(g.shape)
