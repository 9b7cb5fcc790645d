"""Unknown constants of an arm's springs, and of its IMU, as one vector with a prior.

    theta = (log stiffness of gears | log stiffness of the structure | log damping of gears, of the
             structure | lost motion | clock | log process noise | mounting (3))

Stiffnesses, damping and lost motion are relative to the nominal arm. One factor serves the lost
motion of all gears, which a data sheet states for the type: 1 + z, at least 0.
"""

from dataclasses import dataclass, fields

import numpy as np

from armside.arrays import Array

from .elasticity import Elasticity


@dataclass(frozen=True, kw_only=True)
class WayPrior:
    """Standard deviations around the nominal arm."""

    gears: float = 0.2
    """Log stiffness: uniform within +- 30 % is a standard deviation of 0.17."""
    structure: float = 0.7
    """Log stiffness of bearings and links: within a factor of two of the gear beside. ESTIMATE"""
    damping: float = 0.5
    lost_motion: float = 0.3
    """Of its width, relative. ESTIMATE"""
    clock: float = 0.010
    """[s]."""
    process_noise: float = 0.5
    mounting: float = 0.02
    """[rad], rotation of the IMU's housing about each of its axes."""

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) > 0.0:
                raise ValueError(f"{field.name} must be > 0, got {getattr(self, field.name)}")

    def standard_deviation(self, springs: Elasticity) -> Array:
        """(m,), of theta; its mean is 0."""
        stiffness = np.full(len(springs.stiffness), self.structure)
        stiffness[springs.axes] = self.gears
        others = self.damping, self.damping, self.lost_motion, self.clock, self.process_noise
        return np.concatenate([stiffness, others, np.full(3, self.mounting)])


@dataclass(frozen=True, eq=False)
class WayConstants:
    """Springs of an arm, and clock and mounting of its IMU."""

    springs: Elasticity
    clock_offset: float
    """Robot time when the unit's clock shows 0 [s]."""
    process_noise: float
    """`ProcessNoise.fraction`: fraction of the arm's twist that the model leaves unexplained."""
    mounting: Array
    """(3,) [rad], rotation of the IMU's housing from its site."""


def constants_at(nominal: Elasticity, theta: Array, fraction: float) -> WayConstants:
    """Constants of a vector; fraction: expected `ProcessNoise.fraction`."""
    n = len(nominal.stiffness)
    gears, structure, lost, clock, noise = theta[n : n + 5]
    width = max(0.0, 1.0 + float(lost))
    damped = float(np.exp(gears)), float(np.exp(structure))
    springs = nominal.scaled(np.exp(theta[:n]), *damped, width)
    return WayConstants(springs, float(clock), fraction * float(np.exp(noise)), theta[n + 5 :])
