"""Amplification of gear errors by an elastic arm, from the recordings that the errors come from.

Below its first resonance an arm amplifies an error of joint j by 1 / (1 - softness_j f^2). Without
a model of its structure, softness_j is what makes the joint's terms explain most, held to the
softness that all joints have in common as far as the recordings leave it open.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from armside.arrays import Array

from .fit import normal
from .observation import Observation
from .scan import Candidate

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

    Joints without terms have that of all. The third is its standard deviation between joints.
    """
    n = observations[0].n_joints
    largest = float((NEAREST * max(one.band[1] for one in observations)) ** -2)
    spread = SPREAD * largest
    common = _smallest(lambda p: _missed(observations, terms, np.full(n, p)), largest)
    softness = np.full(n, common)
    for joint in sorted({joint for joint, _ in terms}):

        def missed(p: float, joint: int = joint) -> float:
            tried = softness.copy()
            tried[joint] = p
            # Energies are sums of |r|^2 of complex bins: minus the logarithm of the likelihood.
            return _missed(observations, terms, tried) + 0.5 * ((p - common) / spread) ** 2

        softness[joint] = _smallest(missed, largest)
    return [replace(one, softness=softness) for one in observations], softness, spread


def _smallest(missed: Any, largest: float) -> float:
    from scipy.optimize import minimize_scalar

    how: dict[str, Any] = {"bounds": (0.0, largest), "method": "bounded"}
    found: Any = minimize_scalar(missed, options={"xatol": 0.01 * largest}, **how)
    return float(found.x)


def _missed(
    observations: Sequence[Observation], terms: Sequence[Candidate], softness: Array
) -> float:
    parts = (normal(replace(one, softness=softness), terms) for one in observations)
    return -reduce(add, parts).explained()
