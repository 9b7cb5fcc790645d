"""Inverse kinematics of any serial robot of numbers, by damped least squares from a start.

A target is a pose T_base_tool, or a position p_base, whose tool axes are then free. Redundant arms
move least from the start. The work is done by the compiled `numeric_kernel`.
"""

from functools import cache, lru_cache
from math import cos, inf, pi, sin
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, finite_array, real_array

from ..cache import cached_module
from ..compiled import refuse_symbols
from ..dh import Joint, Limits, Robot
from ..rigid import standard_links
from .targets import Cause, joint_jump, limit_passed, refuse_motion

_RESTARTS = 100
_TYPES = {Joint.REVOLUTE: 0, Joint.PRISMATIC: 1, Joint.FIXED: 2}


class NotConvergedError(ValueError):
    """No configuration found for target `index`: `distance` [m] and `angle` [rad] remain at `phi`.

    Both are zero where solutions exist only beyond the joint limits, or past a jump. Along a path
    `cause` says what stands in the way.
    """

    def __init__(
        self,
        robot: Robot,
        index: int,
        count: int,
        phi: Array,
        error: Array,
        cause: Cause | None = None,
        reason: str = "",
    ) -> None:
        self.index, self.phi, self.cause = index, phi, cause
        self.distance, self.angle = (float(np.linalg.norm(part)) for part in (error[:3], error[3:]))
        where = f"target {index} of {count}: " if count > 1 else ""
        missing = f"{self.distance * 1e3:.3g} mm and {np.degrees(self.angle):.3g} deg remain"
        if not error.any() and cause is not Cause.SINGULARITY:
            missing = "solutions were found beyond the joint limits only, the last"
        elif not error.any():
            missing = "only a jump leads on,"
        at = f"phi = {np.round(phi, 4).tolist()} rad"
        because = f" ({cause.value}: {reason})" if cause else ""
        found = f"no configuration of {robot.name} found: {missing} at {at}"
        super().__init__(f"{where}{found}{because}")


def inverse_numeric(
    robot: Robot,
    T: ArrayLike,
    start: ArrayLike,
    tolerance: float = 1e-9,
    *,
    limits: Limits | None = None,
    restarts: int = _RESTARTS,
    nearest: bool = False,
) -> Array:
    """One configuration phi for each target, shape (n,) or (N, n).

    Revolute joints are within half a turn of the start where the limits allow.

    Args:
        T: poses (4, 4) or (N, 4, 4), or positions (3,) or (N, 3) [m].
        start: shape (n,) [rad], where the search for each target starts.
        tolerance: largest remaining error that is accepted [m] and [rad], from 1e-12.
        limits: ranges that a solution is in.
        restarts: further starts, evenly spread over the limits (or a turn), for the targets that
            the first does not solve.
        nearest: try all starts and return the solution found nearest to `start`.

    Raises:
        NotConvergedError: says for which target, and what error remains where.
    """
    first, kernel = finite_array("start", start), _kernel()
    if first.shape != (robot.n_joints,):
        raise ValueError(f"start must have shape ({robot.n_joints},), got {first.shape}")
    _check_tolerance(tolerance)
    if not isinstance(restarts, Integral) or restarts < 0:
        raise ValueError(f"restarts must be a whole number from 0, got {restarts!r}")
    targets, rows, single = _targets(T)
    (chain, turns), ranges = _chain(robot), _ranges(robot, limits)
    starts = np.vstack([first, spread(robot, limits, restarts)])
    n = len(targets)
    phi, error = np.empty((n, len(first))), np.zeros((n, 6))
    outcome = np.empty(n, dtype=np.int64)
    kernel.search(
        chain, turns, targets, rows, starts, ranges, tolerance, nearest, phi, error, outcome
    )
    if outcome.any():
        k = int(np.argmax(outcome != kernel.FOUND))
        remains = error[k] if outcome[k] == kernel.OPEN else np.zeros(6)
        raise NotConvergedError(robot, k, n, phi[k], np.where(np.arange(6) < rows, remains, 0.0))
    return phi[0] if single else phi


def inverse_numeric_path(
    robot: Robot,
    T: ArrayLike,
    start: ArrayLike,
    tolerance: float = 1e-9,
    *,
    limits: Limits | None = None,
) -> Array:
    """Configurations along a sequence of targets, shape (N, n), each started from the one before.

    One compiled call. The branch of the start is kept; a revolute joint that would turn by 90 deg
    from one target to the next ends the path. Redundant arms move least, and where a motor would
    pass its limit it stays there and the others make the motion.

    Args:
        T: poses (N, 4, 4) or positions (N, 3) [m].
        start: shape (n,) [rad]; the first configuration is searched from it.
        tolerance: largest remaining error that is accepted [m] and [rad], from 1e-12.
        limits: ranges that every configuration is in.

    Raises:
        NotConvergedError: the first target that is not reached; says what error remains where, and
            the cause: the motor and its limit, a singularity on the way, or the reach.
    """
    targets, rows, single = _targets(T)
    if single:
        raise ValueError(f"T must be (N, 4, 4) or (N, 3), got {np.shape(T)}; see inverse_numeric")
    _check_tolerance(tolerance)
    path = np.empty((len(targets), robot.n_joints))
    if not len(path):
        return path
    first = T[:1] if isinstance(T, np.ndarray) else np.asarray(T, dtype=np.float64)[:1]
    path[:1] = inverse_numeric(robot, first, start, tolerance, limits=limits)
    error, ranges = np.zeros(6), _ranges(robot, limits)
    k = _kernel().follow(_chain(robot)[0], targets, rows, ranges, tolerance, path, error)
    if k < len(path):
        error[rows:] = 0.0
        if np.abs(error).max() <= tolerance:
            error[:] = 0.0
        target = targets[k] if rows == 6 else targets[k, :3, 3]
        cause, reason = _cause(robot, target, path[k - 1], path[k], error, limits)
        raise NotConvergedError(robot, int(k), len(path), path[k], error, cause, reason)
    return path


def _cause(
    robot: Robot, target: Array, before: Array, phi: Array, error: Array, limits: Limits | None
) -> tuple[Cause, str]:
    """Cause of a target that does not follow, in configuration phi, the solution before it."""
    if not error.any():
        if passed := limits and limit_passed(phi, limits, _kernel().SLACK):
            return Cause.LIMIT, passed
        return Cause.SINGULARITY, joint_jump(robot, before, phi)
    try:
        inverse_numeric(robot, target, before, limits=limits)
    except NotConvergedError as elsewhere:
        if elsewhere.distance or elsewhere.angle:
            return Cause.REACH, "no start leads to the target"
        return Cause.LIMIT, "it is reached beyond the limits only"
    return Cause.SINGULARITY, "the target is reached in another branch only"


@cache
def _kernel() -> Any:
    text = Path(__file__).with_name("numeric_kernel.py").read_text(encoding="utf-8")
    return cached_module("inverse_numeric", "", lambda: text)


def _check_tolerance(tolerance: float) -> None:
    exact = _kernel().EXACT
    if not isinstance(tolerance, Real) or not exact <= tolerance < inf:
        given = f"got {tolerance!r}"
        raise ValueError(f"tolerance must be a number from {exact:g} [m and rad], {given}")


def _targets(T: ArrayLike) -> tuple[Array, int, bool]:
    """Targets (N, 4, 4), the number of error components that count, and True for a single one."""
    given = real_array("T", T)
    if given.shape[-2:] == (4, 4) and given.ndim in (2, 3):
        poses, rows = np.array(given.reshape(-1, 4, 4)), 6
    elif given.shape[-1:] == (3,) and given.ndim in (1, 2):
        poses, rows = np.tile(np.eye(4), (given.size // 3, 1, 1)), 3
        poses[:, :3, 3] = given
    else:
        raise ValueError(f"T must be (4, 4), (N, 4, 4), (3,) or (N, 3), got {given.shape}")
    if not _kernel().are_rigid(poses):
        refuse_motion(given)
    return poses, rows, given.ndim == (2 if rows == 6 else 1)


@lru_cache(maxsize=64)
def _chain(robot: Robot) -> tuple[tuple[Any, ...], Array]:
    """The robot as the kernel takes it, and motor angles (n, n) that turn each joint by 1 rad.

    Its arrays: link parameters, joint types, prismatic joints, coupling, offset.
    """
    refuse_symbols("inverse_numeric", robot.name, robot.free_symbols)
    links, rows = standard_links(robot), []
    for link in links:
        theta, d, a, alpha = (float(getattr(link, name)) for name in ("theta", "d", "a", "alpha"))
        rows.append((theta, d, a, cos(alpha), sin(alpha)))
    types = np.array([_TYPES[link.joint] for link in links], dtype=np.int64)
    M = robot.coupling.copy()
    coupled = not np.array_equal(M, np.eye(len(M)))
    arrays = np.array(rows), types, types[types < 2] == 1, M, robot.offset.copy(), coupled
    return arrays, np.array(np.linalg.inv(M), dtype=np.float64)


@lru_cache(maxsize=64)
def _ranges(robot: Robot, limits: Limits | None) -> tuple[Array, ...]:
    n = robot.n_joints
    if limits is None:
        return np.full(n, -inf), np.full(n, inf), np.empty((0, n)), np.empty(0), np.empty(0)
    if len(limits.lower) != n:
        raise ValueError(f"limits must have {n} motors, got {len(limits.lower)}")
    combinations = np.array([bound.coefficients for bound in limits.coupled]).reshape(-1, n)
    ends = [[getattr(b, end) for b in limits.coupled] for end in ("lower", "upper")]
    arrays = limits.lower, limits.upper, combinations, *ends
    return tuple(np.array(values, dtype=np.float64) for values in arrays)


@lru_cache(maxsize=64)
def spread(robot: Robot, limits: Limits | None, count: int) -> Array:
    """Starts (count, n), evenly spread: an additive recurrence with the generalised golden ratio.

    Without limits a revolute joint has a turn, and a prismatic one the size of the robot.
    """
    n = robot.n_joints
    links, _, prismatic, *_ = _chain(robot)[0]
    size = float(np.abs(links[:, 1:3]).sum()) or 1.0
    half = np.where(prismatic, size, pi)
    lower, upper = -half, half
    if limits is not None:
        lower, upper = np.maximum(limits.lower, -2 * half), np.minimum(limits.upper, 2 * half)
    ratio = 2.0
    for _ in range(40):  # the root of x^(n + 1) = x + 1
        ratio = (1.0 + ratio) ** (1.0 / (n + 1))
    steps = ratio ** -np.arange(1.0, n + 1)
    fractions = (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0
    return lower + (upper - lower) * fractions
