"""Timing of moves, curves of motor angles phi(w), under limits of joints and path.

Moves that follow each other without a stop: each gets a constant limit of speed and of acceleration
in w; between two the speed is what both allow and what can be reached with limited jerk; ruckig
times each. A single move, from rest to rest, is timed under limits that vary along it: a forward
and a backward pass find the highest speed within the limits of speed and acceleration, and a moving
average over the jerk time limits the jerk.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import ruckig

from armside.arrays import Array
from armside.kinematics import CompiledRobot, Limits

from .curves import SAMPLES, Curve
from .instructions import Dynamics, Speed
from .timing import Timing, jerk_limited

CORNER_FRACTION = 0.8
"""Fraction of an acceleration limit for following a bend; the rest is for changing speed."""
TINY = 1e-12
CHECKS = 1000
"""Instants at which a timing is compared with its limits."""


@dataclass(frozen=True, kw_only=True)
class VaryingLimits:
    """Limits at K places, evenly from w = 0 to 1. Motors, then the tool where it has a path.

    They hold while w' <= speed and bend w'^2 + along |w''| <= 1 in every column.
    """

    speed: Array
    """(K,) [1/s]."""
    along: Array
    bend: Array
    """(K, n + 1) [s^2]: first and second derivatives by w over the limit of acceleration."""


def tool_derivatives(curve: Curve, w: Array, robot: CompiledRobot) -> tuple[Array, Array]:
    """First and second derivative of the tool's position by w, (K, 3) [m]."""
    phi, d1, d2 = (np.ascontiguousarray(curve.at(w, k)) for k in range(3))
    first = np.einsum("kij,kj->ki", robot.jacobian(phi)[:, :3], d1)
    return first, robot.acceleration(phi, d1, d2)[:, :3]


def joint_acceleration(speed: Speed, dynamics: Dynamics) -> Array:
    """(n,) [rad/s^2], reduced with the square of the programmed fraction of full speed."""
    full = np.array(dynamics.joint_acceleration)
    return full * speed.share**2 if speed.share else full


def programmed_rate(speed: Speed, full: float, tool_rate: Array | float) -> Array | float:
    """w' [1/s] as programmed. full: at the joints' limits; tool_rate: path [m] per unit of w."""
    if speed.share:
        return speed.share * full
    return (speed.path or 0.0) / np.maximum(tool_rate, TINY)


def curve_bounds(
    curve: Curve, speed: Speed, robot: CompiledRobot, limits: Limits, dynamics: Dynamics, n: int
) -> VaryingLimits:
    """Limits at n places of a curve."""
    w = np.linspace(0.0, 1.0, n)
    d1, d2 = np.abs(curve.at(w, 1)), np.abs(curve.at(w, 2))
    x1, x2 = (np.linalg.norm(x, axis=1) for x in tool_derivatives(curve, w, robot))
    of_joints = joint_acceleration(speed, dynamics)
    of_path = float(curve.on_path) / dynamics.path_acceleration
    bend = np.column_stack([d2 / of_joints, of_path * x2])
    full = (np.array(limits.speed) / np.maximum(d1, TINY)).min(axis=1)
    wanted = programmed_rate(speed, full.min(), x1)
    bent = np.sqrt(CORNER_FRACTION / np.maximum(bend.max(axis=1), TINY))
    return VaryingLimits(
        speed=np.minimum(np.minimum(full, wanted), bent),
        along=np.column_stack([d1 / of_joints, of_path * x1]),
        bend=bend,
    )


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
    """From rest at the start of the first curve to rest at the end of the last.

    A forward and a backward pass find the speeds in w at the start and the end of each piece.
    """
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
    timings = list[Timing]()
    starts = junction[:-1] / np.maximum(rate_first, TINY)
    ends = junction[1:] / np.maximum(rate_last, TINY)
    for piece, first, last in zip(limits, starts.tolist(), ends.tolist(), strict=True):
        asked = ruckig.InputParameter(1)
        asked.current_velocity, asked.target_velocity = [first], [last]
        asked.target_position, asked.max_velocity = [1.0], [max(piece.speed, first, last)]
        asked.max_acceleration = [piece.acceleration]
        asked.max_jerk = [piece.acceleration / jerk_time]
        timings.append(jerk_limited(asked, f"from {first} to {last} 1/s"))
    return timings


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


def fastest(bounds: VaryingLimits, jerk_time: float) -> Timing:
    """Fastest timing of w from 0 to 1, at rest at both ends; jerk_time: of an acceleration [s]."""
    x = bounds.speed**2
    x[[0, -1]] = 0.0
    x = _reached(x, bounds.along, bounds.bend)
    x = _reached(x[::-1], bounds.along[::-1], bounds.bend[::-1])[::-1]
    timing = averaged(x, jerk_time)
    # Where limits change within the jerk time, an average may pass them: by 0.6 % in our programs.
    factor = max(1.0, _excess(timing, bounds))
    state = timing.state * factor ** -np.arange(4.0)
    return Timing(timing.start * factor, state, timing.duration * factor)


def _reached(x: Array, along: Array, bend: Array) -> Array:
    """w'^2 where it can rise no faster than acceleration allows, at both ends of each interval."""
    x, step = x.copy(), 1.0 / (len(x) - 1)
    along = np.maximum(np.maximum(along[:-1], along[1:]), TINY)
    bend = np.maximum(bend[:-1], bend[1:])
    for i in range(len(x) - 1):
        steepest = (np.maximum(1.0 - bend[i] * x[i], 0.0) / along[i]).min()
        x[i + 1] = min(x[i + 1], x[i] + 2.0 * step * steepest)
    return x


def averaged(x: Array, window: float) -> Timing:
    """Motion of w'^2 = x on an even grid, linear between, averaged over `window` [s] of time.

    Its acceleration is constant in each interval, its average linear: phases of constant jerk.
    """
    v, step = np.sqrt(x), 1.0 / (len(x) - 1)
    knots = np.concatenate([[0.0], np.cumsum(2.0 * step / (v[:-1] + v[1:]))])
    acceleration = np.diff(x) / (2.0 * step)
    start = np.unique(np.concatenate([knots, knots + window]))
    middle = start[:-1] + 0.5 * np.diff(start)
    held = np.concatenate([[0.0], acceleration, [0.0]])  # between knots, zero outside
    times = middle, middle - window
    entering, leaving = (held[np.searchsorted(knots, time, side="right")] for time in times)
    return Timing.of_jerk(start[:-1], (entering - leaving) / window, float(start[-1]))


def _excess(timing: Timing, bounds: VaryingLimits) -> float:
    """Factor on the duration with which a timing keeps all limits."""
    w, v, a = timing.at(np.linspace(0.0, timing.duration, CHECKS))
    grid = np.linspace(0.0, 1.0, len(bounds.speed))
    along, bend = (
        np.stack([np.interp(w, grid, column) for column in table.T], axis=1)
        for table in (bounds.along, bounds.bend)
    )
    used = bend * (v**2)[:, np.newaxis] + along * np.abs(a)[:, np.newaxis]
    return float(max((v / np.interp(w, grid, bounds.speed)).max(), np.sqrt(used.max())))
