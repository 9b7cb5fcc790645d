"""Slow motion of all motors around a pose, in which the errors of gears show at the tool."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics import Limits

from ..robot.virtual_robot import LOG_PERIOD

SINES = 3
"""In the motion of each motor."""


@dataclass(frozen=True, kw_only=True)
class Excitation:
    """Sums of sines, of other frequencies for each motor."""

    duration: float = 120.0
    """[s]."""
    frequency: tuple[float, float] = (0.015, 0.05)
    amplitude: tuple[float, float] = (0.13, 0.26)
    """[Hz] and [rad], range of each sine."""
    ramp: float = 3.0
    """[s], from rest and to rest."""

    def reference(self, centre: Array, limits: Limits, rng: np.random.Generator) -> Array:
        """Motor angles (N, n) [rad] at the log rate around `centre` (n,), at rest at both ends.

        Where a joint limit is near, the whole motion is made smaller.

        Raises ValueError for a centre outside of the limits, or so near that hardly any motion is
        left.
        """
        time = np.arange(0.0, self.duration, LOG_PERIOD)
        motion = np.zeros((len(time), len(centre)))
        for joint in range(len(centre)):
            for _ in range(SINES):
                f, a = rng.uniform(*self.frequency), rng.uniform(*self.amplitude)
                phase = rng.uniform(0.0, 2.0 * np.pi)
                motion[:, joint] += a * np.sin(2.0 * np.pi * f * time + phase)
        ramp = np.clip(time / self.ramp, 0.0, 1.0)
        ramp = ramp**2 * (3.0 - 2.0 * ramp)
        motion *= (ramp * ramp[::-1])[:, None]
        for size in np.arange(1.0, 0.25, -0.05):
            if limits.contain(centre + size * motion).all():
                return centre + size * motion
        raise ValueError("the pose is too near to a joint limit for a motion that excites gears")
