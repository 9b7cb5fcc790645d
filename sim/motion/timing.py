"""Timing along a path in phases of constant jerk: fastest by ruckig, or of a speed profile."""

from dataclasses import dataclass

import numpy as np
import ruckig
from numpy.typing import ArrayLike

from armside.arrays import Array, check_numbers


@dataclass(frozen=True, kw_only=True)
class PathLimits:
    """Limits of the motion planner for the tool on its path."""

    acceleration: float = 1.3
    """[m/s^2], along the path and across it. A 5 mm circle is then capped at sqrt(1.3 * 0.005) = 81
    mm/s, the saturation of thesis Fig. 9.6; fitted (calibration of the large robot)."""
    jerk: float = 4.0 * 0.040 / 0.120**2
    """[m/s^3]. A ramp to v that stays below the acceleration limit lasts 2 sqrt(v / jerk): this
    value gives the calibrated ramp of 120 ms to 40 mm/s, with a peak of 0.67 m/s^2."""

    def __post_init__(self) -> None:
        check_numbers(self, "acceleration", "jerk")
        for name in ("acceleration", "jerk"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"path {name} must be > 0, got {value}")

    def cornering_speed(self, radius: float) -> float:
        """Fastest speed around a radius of curvature [m/s]: v^2 / radius <= acceleration."""
        return float(np.sqrt(self.acceleration * radius))

    def ramp_length(self, speed: float) -> float:
        """Arc length [m] from rest to `speed`: half of speed times the ramp's time, by symmetry."""
        peak = min(self.acceleration, float(np.sqrt(self.jerk * speed)))
        return 0.5 * speed * (speed / peak + peak / self.jerk)


@dataclass(frozen=True)
class Timing:
    """s(t) in phases of constant jerk, from rest at t = 0 to rest at t = duration."""

    start: Array
    """(P,) [s], start of each phase."""
    state: Array
    """(P, 4): s, v, a [m, m/s, m/s^2] at the start of each phase, and its jerk [m/s^3]."""
    duration: float
    """[s]."""

    @classmethod
    def of_jerk(cls, start: Array, jerk: Array, duration: float) -> "Timing":
        """Phases from rest, of which start (P,) [s] and jerk (P,) [m/s^3] are known."""
        h = np.diff(start, append=duration)
        a = _summed(h * jerk)
        v = _summed(h * (a + h * jerk / 2))
        s = _summed(h * (v + h * (a / 2 + h * jerk / 6)))
        return cls(start, np.stack([s, v, a, jerk], axis=1), duration)

    def at(self, time: ArrayLike) -> tuple[Array, Array, Array]:
        """Arc length, speed and acceleration at `time`; at rest before 0 and after the end."""
        t = np.clip(np.asarray(time, dtype=np.float64), 0.0, self.duration)
        phase = np.searchsorted(self.start, t, side="right") - 1
        s, v, a, j = self.state[phase].T
        h = t - self.start[phase]
        moving = (t > 0.0) & (t < self.duration)
        return (
            s + h * (v + h * (a / 2 + h * j / 6)),
            np.where(moving, v + h * (a + h * j / 2), 0.0),
            np.where(moving, a + h * j, 0.0),
        )

    @property
    def top_speed(self) -> float:
        """[m/s]."""
        return float(np.max(self.state[:, 1]))

    @property
    def cruise(self) -> tuple[float, float]:
        """Start and end [s] of the longest phase at constant speed."""
        _, speed, acceleration, jerk = self.state.T
        constant = (np.abs(acceleration) < 1e-9) & (jerk == 0.0) & (speed > 0.0)
        if not np.any(constant):
            return (self.duration / 2, self.duration / 2)
        length = np.where(constant, np.diff(self.start, append=self.duration), 0.0)
        longest = int(np.argmax(length))
        return float(self.start[longest]), float(self.start[longest] + length[longest])


def rest_to_rest(length: float, speed: float, limits: PathLimits) -> Timing:
    """The fastest timing over `length` [m] that respects `speed` [m/s] and the limits."""
    for name, value in (("path length", length), ("speed", speed)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be > 0, got {value}")
    asked = ruckig.InputParameter(1)
    asked.target_position, asked.max_velocity = [length], [speed]
    asked.max_acceleration, asked.max_jerk = [limits.acceleration], [limits.jerk]
    return jerk_limited(asked, f"over {length} m at {speed} m/s")


def jerk_limited(asked: ruckig.InputParameter, description: str) -> Timing:
    """Fastest timing under limits of ruckig, without empty phases. RuntimeError with the text."""
    trajectory = ruckig.Trajectory(1)
    result = ruckig.Ruckig(1).calculate(asked, trajectory)
    if result not in (ruckig.Result.Finished, ruckig.Result.Working):
        raise RuntimeError(f"no timing {description}: {result}")
    profile = trajectory.profiles[0][0]
    phase_time = np.asarray(profile.t)
    start, used = np.concatenate([[0.0], np.cumsum(phase_time)[:-1]]), phase_time > 0.0
    rows = (profile.p, profile.v, profile.a, profile.j)
    state = np.stack([np.asarray(row)[: len(phase_time)] for row in rows], axis=1)
    return Timing(start[used], state[used], float(trajectory.duration))


def profile_timing(acceleration: Array, steps: Array, jerk: float, ramp: float) -> Timing:
    """Ramps of `jerk` for `ramp` [s] at both ends, and between them `acceleration` for `steps` [s].

    Each change of acceleration is spread over half of the shorter step before and after it.
    """
    half = np.concatenate([[0.0], 0.5 * np.minimum(steps[:-1], steps[1:]), [0.0]])
    knots = ramp + np.concatenate([[0.0], np.cumsum(steps)])
    change = np.diff(acceleration)
    held = np.column_stack([knots[:-1] + half[:-1], np.zeros(len(steps))])
    blends = np.column_stack([knots[1:-1] - half[1:-1], change / (2.0 * half[1:-1])])
    phases = np.empty((2 * len(steps) - 1, 2))
    phases[::2], phases[1::2] = held, blends
    start = np.concatenate([[0.0], phases[:, 0], knots[-1:]])
    j = np.concatenate([[jerk], phases[:, 1], [jerk]])
    return Timing.of_jerk(start, j, float(knots[-1] + ramp))


def _summed(change: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(change)[:-1]])
