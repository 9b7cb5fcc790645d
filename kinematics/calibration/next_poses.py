"""Poses to measure next: D-optimal, the largest growth of the determinant of the information."""

import numpy as np

from armside.arrays import Array

from ..limits import Limits
from .fit import Fit, jacobian_of_points

CANDIDATES = 1000


def next_poses(fit: Fit, limits: Limits, number: int, rng: np.random.Generator) -> Array:
    """Motor angles (number, n) of poses that tell most about the parameters of a fit.

    Greedy choice among random configurations within the limits; each pose is chosen in view of
    what was measured and of those chosen before it.
    """
    drawn = rng.uniform(limits.lower, limits.upper, (CANDIDATES, len(limits.lower)))
    candidates = drawn[limits.contain(drawn)]
    J, covariance = jacobian_of_points(fit, candidates) / fit.noise, fit.covariance.copy()
    chosen: list[int] = []
    for _ in range(number):
        seen = J @ covariance
        gain = np.linalg.slogdet(np.eye(3) + seen @ np.swapaxes(J, 1, 2))[1]
        gain[chosen] = -np.inf
        best = int(gain.argmax())
        chosen.append(best)
        K = np.linalg.solve(np.eye(3) + J[best] @ seen[best].T, seen[best])
        covariance -= seen[best].T @ K
    return candidates[chosen]
