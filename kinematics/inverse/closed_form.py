"""Inverse kinematics in closed form: every branch of two kinds of arm with six revolute axes.

They are elbow arms with a spherical wrist, thesis (2.7)-(2.10), and arms whose axes 2, 3 and 4 are
parallel, as Universal Robots builds them; a robot's kind follows from its Denavit-Hartenberg
numbers. The wrist centre is where axes 5 and 6 meet. Solutions are motor angles phi, so a coupling
is solved for as well. Branches are numbered 4 shoulder + 2 elbow + wrist, each 0 or 1: the shoulder
facing the target or facing away, the elbow angle positive or negative, the wrist regular or flipped
(with parallel axes: the sine of theta5 positive or negative).
"""

from dataclasses import dataclass
from enum import IntFlag
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, shown

from ..cache import cached_module
from ..dh import Limits, Robot
from .six_axes import ClosedArm, solvable_arm
from .targets import batch, limit_passed


class Singularity(IntFlag):
    """Singularities of a solution; an angle that one leaves free keeps its reference value."""

    NONE = 0
    SHOULDER = 1
    """The wrist centre is on axis 1, where theta1 is free; with an offset of the shoulder, in the
    plane of axis 1 that the offset leaves it: two shoulder branches coincide."""
    ELBOW = 2
    """The arm is stretched or folded: two elbow branches coincide."""
    WRIST = 4
    """Axes 4 and 6 align. Of a spherical wrist only a combination of theta4 and theta6 is
    determined, and theta4 is free. With axes 2, 3 and 4 parallel, axis 6 is parallel to all of them
    and theta6 is free; where the arm does not reach the target with its reference value, it takes
    the nearest value with which the arm, then stretched or folded, does."""


class UnreachableError(ValueError):
    """Target `index` of a batch, `distance` [m] outside the reach of the wrist centre."""

    def __init__(self, robot: Robot, index: int, distance: float) -> None:
        self.index, self.distance = index, distance
        super().__init__(
            f"target {index} is out of reach of {robot.name}: its wrist centre lies "
            f"{distance * 1e3:.3f} mm outside the workspace"
        )


def refuse_unreachable(robot: Robot, outside: Array, touching: float = 0.0) -> None:
    """Raise UnreachableError for the first target (N,) by more than `touching` [m] outside."""
    if (beyond := outside > touching).any():
        index = int(np.argmax(beyond))
        raise UnreachableError(robot, index, float(outside[index]))


class JointRangeError(ValueError):
    """Target `index` of a path, where a joint leaves its range as `passed` says."""

    def __init__(self, robot: Robot, limits: Limits, path: Array) -> None:
        self.index = index = int(np.argmin(limits.contain(path)))
        phi = np.degrees(path[index]).round(2).tolist()
        self.passed = f"{limit_passed(path[index], limits)} [rad], at phi = {phi} deg"
        where = f"target {index} of {len(path)} leaves the joint limits of {robot.name}"
        super().__init__(f"{where}: {self.passed}")


@dataclass(frozen=True)
class Branches:
    """All solutions of a batch of targets; a single target has no leading axis.

    Motor angles (..., 8, 6) [rad], NaN where a branch does not exist; flags `Singularity` (..., 8).
    """

    phi: Array
    exists: NDArray[np.bool_]
    singular: NDArray[np.int8]


def inverse_branches(robot: Robot, T: ArrayLike, reference: ArrayLike | None = None) -> Branches:
    """Every branch for each target.

    Args:
        T: shape (4, 4) or (N, 4, 4), T_base_tool.
        reference: shape (6,), phi near which angles are unwrapped and free angles are chosen;
            zero by default.

    Raises:
        UnreachableError: a target has no solution; says its distance from the workspace.
        UnsolvableGeometryError: the robot is of another kind.
    """
    arm = solvable_arm(robot)
    W, single = _targets(arm, T)
    n, g, theta_start = len(W), arm.geometry, arm.M @ _configuration(reference) + arm.constant
    phi, flags, outside = np.empty((n, 8, 6)), np.empty((n, 8), dtype=np.int8), np.empty(n)
    kernel = _kernel(arm.kernel)
    kernel.solve_all(W, g, arm.M_inverse, arm.constant, theta_start, phi, flags, outside)
    refuse_unreachable(robot, outside)
    exists = flags >= 0
    phi[~exists] = np.nan
    found = phi, exists, np.maximum(flags, 0)
    return Branches(*(array[0] for array in found)) if single else Branches(*found)


def inverse_nearest(
    robot: Robot, T: ArrayLike, previous: ArrayLike | None = None, limits: Limits | None = None
) -> Array:
    """The solution nearest to a previous configuration (zero by default), shape (6,) [rad].

    Args:
        T: shape (4, 4).
        limits: ranges that the solution is in; multiples of 2 pi are added to reach them.

    Raises:
        ValueError: no branch is within the limits.
    """
    start = _configuration(previous)
    if limits is not None and len(limits.lower) != 6:
        raise ValueError(f"limits must have 6 motors, got {len(limits.lower)}")
    inside = start if limits is None else np.clip(start, limits.lower, limits.upper)
    found = inverse_branches(robot, T, inside)
    if found.phi.ndim != 2:
        raise ValueError(f"T must have shape (4, 4), got {np.shape(T)}; see inverse_path")
    candidates = found.phi[found.exists]
    if limits is not None:
        # each with -2 pi, 0, 2 pi added to its joints in every combination
        turns = 2 * np.pi * np.stack(np.meshgrid(*[[-1, 0, 1]] * 6), axis=-1).reshape(-1, 6)
        turned = np.linalg.solve(robot.coupling, turns.T).T
        every = (candidates[:, None] + turned).reshape(-1, 6)
        candidates = every[limits.contain(every)]
        if not len(candidates):
            raise ValueError(
                f"the target is in reach of {robot.name}, but all {found.exists.sum()} branches "
                f"are outside the joint limits: in the best {limit_passed(every, limits)} [rad]"
            )
    return candidates[np.argmin(((candidates - start) ** 2).sum(axis=-1))]


def inverse_path(
    robot: Robot, T: ArrayLike, start: ArrayLike | None = None, limits: Limits | None = None
) -> Array:
    """One branch through a sequence of targets, shape (N, 6) [rad], without jumps by 2 pi.

    Args:
        T: shape (N, 4, 4), T_base_tool along the path.
        start: shape (6,), the first solution is the nearest to it (to zero by default).
        limits: ranges of the first solution; leaving them later is an error.
    """
    arm = solvable_arm(robot)
    W, single = _targets(arm, T)
    if single:
        raise ValueError(f"T must have shape (N, 4, 4), got {np.shape(T)}; see inverse_nearest")
    path = np.empty((len(W), 6))
    if not len(W):
        return path
    T = np.asarray(T, dtype=np.float64)
    path[0] = inverse_nearest(robot, T[0], start, limits)
    outside, flag = np.zeros(len(W)), np.zeros(len(W), dtype=np.int8)
    kernel = _kernel(arm.kernel)
    kernel.follow(W, arm.geometry, arm.M, arm.M_inverse, arm.constant, path, flag, outside)
    refuse_unreachable(robot, outside)
    if limits is not None and not limits.contain(path).all():
        raise JointRangeError(robot, limits, path)
    return path


@cache
def _kernel(kind: str) -> Any:
    """The loops of `kernel` compiled with the branches of a kind."""

    def text() -> str:
        kernel, loops = (
            Path(__file__).with_name(name).read_text(encoding="utf-8")
            for name in (f"{kind}_kernel.py", "kernel.py")
        )
        return kernel + loops.replace("from .wrist_kernel import branches\n", "")

    return cached_module(f"inverse_{kind}", "", text)


def _configuration(phi: ArrayLike | None) -> Array:
    start = np.zeros(6) if phi is None else np.asarray(phi, dtype=np.float64)
    if start.shape != (6,) or not np.isfinite(start).all():
        raise ValueError(f"a configuration must be 6 finite motor angles, got {shown(phi)}")
    return start


def _targets(arm: ClosedArm, T: ArrayLike) -> tuple[Array, bool]:
    """Checked targets as transforms from the arm's base to just after Rot_z(theta6)."""
    poses, single = batch(T)
    return np.ascontiguousarray(arm.head_inverse @ poses @ arm.tail_inverse), single
