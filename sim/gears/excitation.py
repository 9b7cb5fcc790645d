"""Slow motion of all motors around a pose, in which the errors of gears show at the tool."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics import Limits

from ..robot.virtual_robot import LOG_PERIOD

SINES = 3
"""In the motion of each motor."""
OF_SLIDE = 0.1
"""Motion of a slide [m] for each radian of other motors. ESTIMATE: strokes are 0.2 m and more."""
SMALLEST = 0.3
"""Fraction of the motion that must have room."""


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

    def reference(
        self,
        centre: Array,
        limits: Limits,
        rng: np.random.Generator,
        slides: Sequence[bool] | None = None,
    ) -> Array:
        """Motor angles (N, n) [rad] at the log rate around `centre` (n,), at rest at both ends.

        Where a joint limit is near, the whole motion is made smaller. slides: (n,), True for each
        prismatic axis, whose motion is in [m]; none if None.

        Raises ValueError for a centre outside of the limits, or so near that hardly any motion is
        left; names the axis.
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
        if slides is not None:
            motion[:, np.array(slides)] *= OF_SLIDE
        for size in np.arange(1.0, SMALLEST - 0.05, -0.05):
            if limits.contain(centre + size * motion).all():
                return centre + size * motion
        said = _nearest(centre, SMALLEST * motion, limits)
        raise ValueError(f"{said} too near to a joint limit for a motion that excites gears")


def _nearest(centre: Array, motion: Array, limits: Limits) -> str:
    """The axis that leaves its range farthest, over its range; the pose where only sums do."""
    over = np.maximum(
        (centre + motion - limits.upper).max(axis=0), (limits.lower - centre - motion).max(axis=0)
    )
    over /= np.subtract(limits.upper, limits.lower)
    worst = int(over.argmax())
    return f"axis {worst + 1} of the pose is" if over[worst] > 0.0 else "the pose is"
