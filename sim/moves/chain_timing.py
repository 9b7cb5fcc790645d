"""Timing of curves that follow each other without a stop, under joint and path limits.

Each piece gets a constant speed limit and acceleration limit in its own parameter w; between pieces
the speed is what both allow and what can be reached with limited jerk. ruckig times each piece.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import ruckig

from armside.arrays import Array
from armside.kinematics import CompiledRobot, Limits

from ..cut.timing import Timing, jerk_limited
from .bounds import CORNER_FRACTION, TINY, joint_acceleration, programmed_rate, tool_derivatives
from .curves import SAMPLES, Curve
from .instructions import Dynamics, Speed


@dataclass(frozen=True, kw_only=True)
class PieceLimits:
    """Constant limits of one curve, in its parameter w."""

    speed: float
    acceleration: float
    """[1/s] and [1/s^2]."""
    limited_by: str
    """Limit that keeps the speed below the programmed one; empty if none does."""
    tool_rate: float
    """[m] of tool path per unit of w, the largest on the curve."""
    full_speed: float
    """Speed at which a joint reaches its speed limit [1/s]."""


def piece_limits(
    curve: Curve, speed: Speed, robot: CompiledRobot, limits: Limits, dynamics: Dynamics
) -> PieceLimits:
    """Speed and acceleration limits of a curve."""
    w = np.linspace(0.0, 1.0, SAMPLES)
    d1, d2 = np.abs(curve.at(w, 1)), np.abs(curve.at(w, 2))
    x1, x2 = tool_derivatives(curve, w, robot)
    tool_rate = float(np.linalg.norm(x1, axis=1).max())
    bend = float(np.linalg.norm(x2, axis=1).max()) if curve.on_path else 0.0

    joint_speed = np.array(limits.speed) / np.maximum(d1.max(axis=0), TINY)
    of_joints = joint_acceleration(speed, dynamics)
    joint_bend = np.sqrt(CORNER_FRACTION * of_joints / np.maximum(d2.max(axis=0), TINY))
    full_speed = float(joint_speed.min())
    wanted = float(programmed_rate(speed, full_speed, tool_rate))
    caps = {f"speed of motor {i + 1}": float(v) for i, v in enumerate(joint_speed)}
    caps |= {f"acceleration of motor {i + 1}": float(v) for i, v in enumerate(joint_bend)}
    if bend > TINY:
        of_path = CORNER_FRACTION * dynamics.path_acceleration / bend
        caps["path acceleration"] = float(np.sqrt(of_path))
    name, cap = min(caps.items(), key=lambda item: item[1])
    top = min(wanted, cap)
    acceleration = float(((of_joints - d2 * top**2) / np.maximum(d1, TINY)).min())
    if curve.on_path:
        along = np.sqrt(dynamics.path_acceleration**2 - (bend * top**2) ** 2)
        acceleration = min(acceleration, float(along) / max(tool_rate, TINY))
    return PieceLimits(
        speed=top,
        acceleration=acceleration,
        limited_by="" if wanted <= cap else name,
        tool_rate=tool_rate,
        full_speed=full_speed,
    )


def time_chain(
    curves: Sequence[Curve], limits: Sequence[PieceLimits], jerk_time: float
) -> list[Timing]:
    """From rest at the start of the first curve to rest at the end of the last."""
    ends = _end_speeds(curves, limits, jerk_time)
    return [_timed(*piece, jerk_time) for piece in zip(limits, *ends, strict=True)]


def _end_speeds(
    curves: Sequence[Curve], limits: Sequence[PieceLimits], jerk_time: float
) -> tuple[Array, Array]:
    """Speed in w at the start and at the end of each piece: a forward and a backward pass."""
    n = len(curves)
    rate_first = np.array([np.linalg.norm(c.at(0.0, 1)) for c in curves])
    rate_last = np.array([np.linalg.norm(c.at(1.0, 1)) for c in curves])
    # Joint-space speed |dphi/dt| at the joints between pieces, common to both sides.
    junction = np.zeros(n + 1)
    for j in range(1, n):
        junction[j] = min(limits[j - 1].speed * rate_last[j - 1], limits[j].speed * rate_first[j])
    for j in range(n):
        start = junction[j] / max(rate_first[j], TINY)
        reach = _reachable(start, limits[j], jerk_time) * rate_last[j]
        junction[j + 1] = min(junction[j + 1], reach)
    for j in reversed(range(n)):
        end = junction[j + 1] / max(rate_last[j], TINY)
        junction[j] = min(junction[j], _reachable(end, limits[j], jerk_time) * rate_first[j])
    return junction[:-1] / np.maximum(rate_first, TINY), junction[1:] / np.maximum(rate_last, TINY)


def _reachable(speed: float, limits: PieceLimits, jerk_time: float) -> float:
    """Highest speed at the other end of a piece (length 1) without acceleration at either end."""
    jerk = limits.acceleration / jerk_time

    def length(end: float) -> float:
        change = end - speed
        peak = min(limits.acceleration, np.sqrt(jerk * change))
        return 0.5 * (speed + end) * (change / peak + peak / jerk) if change > 0.0 else 0.0

    low, high = speed, max(limits.speed, speed)
    if length(high) <= 1.0:
        return high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if length(middle) <= 1.0 else (low, middle)
    return low * (1.0 - 1e-9)


def _timed(limits: PieceLimits, first: float, last: float, jerk_time: float) -> Timing:
    asked = ruckig.InputParameter(1)
    asked.current_velocity, asked.target_velocity = [first], [last]
    asked.target_position, asked.max_velocity = [1.0], [max(limits.speed, first, last)]
    asked.max_acceleration = [limits.acceleration]
    asked.max_jerk = [limits.acceleration / jerk_time]
    return jerk_limited(asked, f"from {first} to {last} 1/s")
