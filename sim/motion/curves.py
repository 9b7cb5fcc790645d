"""Geometry of moves as curves of motor angles phi(w), w from 0 to 1."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.kinematics import (
    CompiledRobot,
    Limits,
    UnreachableError,
    UnsolvableGeometryError,
    inverse_nearest,
    inverse_numeric_path,
    inverse_path,
)
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion, slerp, to_quaternion

from .instructions import MoveC, MoveJ, MoveL, Target

if TYPE_CHECKING:
    from scipy.interpolate import BPoly, PPoly

NODE_DISTANCE = 0.002
"""Distance between solutions of the inverse kinematics on a path [m]; a spline joins them."""
NODE_ANGLE = np.deg2rad(0.5)
"""Angle between the orientations of two solutions [rad]."""
LARGEST_FRACTION = 0.49
"""Largest fraction of a move that a zone takes at either end."""
HELD_FROM = 6
"""Axes from which on a move sets the tool's orientation too."""
PointAt = Callable[[Array], Array]
"""(N,) fractions of a path -> (N, 3) [m]."""
SAMPLES = 201
"""Points of a curve at which its extremes are looked for."""


@dataclass(frozen=True)
class Curve:
    """A part of a polynomial curve of motor angles."""

    polynomial: "PPoly | BPoly"
    """phi(u), u from 0 to 1."""
    first: float = 0.0
    last: float = 1.0
    on_path: bool = False
    """True where the tool follows a line or circle: limits of the path apply."""

    def at(self, w: ArrayLike, derivative: int = 0) -> Array:
        """phi or a derivative by w, shape (..., n)."""
        span = self.last - self.first
        u = self.first + span * np.asarray(w, dtype=np.float64)
        return span**derivative * self.polynomial(u, derivative)


def move_curve(
    move: MoveJ | MoveL | MoveC, start: Array, robot: CompiledRobot, limits: Limits
) -> Curve:
    """Curve of a move from motor angles `start`, zones included; ValueError where there is none."""
    from scipy.interpolate import PPoly

    if isinstance(move, MoveJ):
        end = _motors(move.to, start, robot, limits)
        return Curve(PPoly(np.stack([end - start, start])[:, np.newaxis], [0.0, 1.0]))
    T = robot.pose(start)
    p = T[:3, 3]
    way = np.array(move.to.position) - p
    if isinstance(move, MoveC):
        return _followed(*_arc(T, move), start, T, move.to, robot)
    length = float(np.linalg.norm(way))
    return _followed(length, lambda u: p + u[:, np.newaxis] * way, start, T, move.to, robot)


def _motors(to: Target, start: Array, robot: CompiledRobot, limits: Limits) -> Array:
    if to.motors is not None:
        return np.array(to.motors)
    T_start = robot.pose(start)
    T = transform(_end_rotation(T_start, to), np.array(to.position))
    near = start if to.near is None else np.array(to.near)
    try:
        return inverse_nearest(robot.robot, T, near, limits)
    except UnsolvableGeometryError:
        return _numeric(robot, T[np.newaxis], near, limits)[0]
    except UnreachableError as error:
        raise ValueError(_unreachable("at its target", error, robot)) from error


def _numeric(robot: CompiledRobot, T: Array, start: Array, limits: Limits | None) -> Array:
    """Motor angles (N, n) of poses T (N, 4, 4); positions alone of an arm below six axes."""
    targets = T if robot.robot.n_joints >= HELD_FROM else T[:, :3, 3]
    return inverse_numeric_path(robot.robot, targets, start, limits=limits)


def _unreachable(where: str, error: UnreachableError, robot: CompiledRobot) -> str:
    return (
        f"{where} the wrist centre would lie {1e3 * error.distance:.1f} mm outside the workspace "
        f"of {robot.robot.name}"
    )


def _end_rotation(T_start: Array, to: Target) -> Array:
    return T_start[:3, :3] if to.quaternion is None else from_quaternion(to.quaternion)


def _arc(T: Array, move: MoveC) -> tuple[float, PointAt]:
    """The circle through three points, from the first over the second to the third."""
    start, via, end = T[:3, 3], np.array(move.via), np.array(move.to.position)
    normal = np.cross(via - start, end - via)
    area = np.linalg.norm(normal)
    sides = np.linalg.norm(via - start) * np.linalg.norm(end - via)
    if area < 1e-6 * max(sides, 1e-9):
        raise ValueError("the start, via and end points lie on one line: no circle through them")
    n = normal / area
    a, b = via - start, end - start
    c = np.cross((a @ a) * b - (b @ b) * a, np.cross(a, b))
    c = c / (2.0 * np.sum(np.cross(a, b) ** 2))  # centre of the circle, from the start
    x = -c / np.linalg.norm(c)
    y, radius = np.cross(n, x), float(np.linalg.norm(c))
    to_end = b - c
    angle = float(np.arctan2(to_end @ y, to_end @ x) % (2.0 * np.pi))

    def point(u: Array) -> Array:
        at = (u * angle)[:, np.newaxis]
        return start + c + radius * (np.cos(at) * x + np.sin(at) * y)

    return radius * angle, point


def _followed(
    length: float, point: PointAt, start: Array, T: Array, to: Target, robot: CompiledRobot
) -> Curve:
    """Motor angles along a path, rotated at an even rate over its length."""
    from scipy.interpolate import CubicSpline

    q_start, q_end = to_quaternion(T[:3, :3]), to_quaternion(_end_rotation(T, to))
    rotation = 2.0 * np.arccos(np.clip(abs(q_start @ q_end), 0.0, 1.0))
    if length < 1e-6 and rotation < 1e-6:
        raise ValueError("the move ends where it starts")
    n = 1 + int(np.ceil(max(length / NODE_DISTANCE, rotation / NODE_ANGLE, 50)))
    u = np.linspace(0.0, 1.0, n)
    poses = transform(from_quaternion(slerp(q_start, q_end, u)), point(u))
    try:
        phi = inverse_path(robot.robot, poses, start)
    except UnsolvableGeometryError:
        phi = _numeric(robot, poses, start, None)
    except UnreachableError as error:
        where = f"{100 * u[error.index]:.0f} % of the way"
        raise ValueError(_unreachable(where, error, robot)) from error
    return Curve(CubicSpline(u, phi), on_path=True)


def check_limits(curve: Curve, limits: Limits) -> None:
    """Raise ValueError where a curve leaves a joint's range, with joint, angle and place."""
    w = np.linspace(0.0, 1.0, SAMPLES)
    phi = curve.at(w)
    ranges = list(zip(np.eye(len(limits.lower)), limits.lower, limits.upper, strict=True))
    ranges += [(np.array(b.coefficients), b.lower, b.upper) for b in limits.coupled]
    for c, low, high in ranges:
        value = phi @ c
        outside = (value < low - 1e-9) | (value > high + 1e-9)
        if outside.any():
            worst = int(np.argmax(np.maximum(low - value, value - high)))
            raise ValueError(
                f"{_combination(c)} leaves its range of {np.degrees(low):g} to "
                f"{np.degrees(high):g} deg {100 * w[np.argmax(outside)]:.0f} % of the way and "
                f"reaches {np.degrees(value[worst]):.1f} deg"
            )


def _combination(c: Array) -> str:
    """Name of a combination of joints, such as "motor 3 - motor 2"."""
    order = sorted(np.flatnonzero(c), key=lambda i: -c[i])
    text = " ".join(f"{'+' if c[i] > 0 else '-'} motor {i + 1}" for i in order)
    return text.removeprefix("+ ")


def blend(before: Curve, after: Curve) -> Curve:
    """Rounded corner from the end of one shortened curve to the start of the next.

    A quintic whose ends match angle, first and second derivative. The removed ends are scaled by
    two, as on a parabola: at constant w', speed and acceleration are continuous.
    """
    from scipy.interpolate import BPoly

    leg_in = 2.0 * (1.0 - before.last) / (before.last - before.first)
    leg_out = 2.0 * after.first / (after.last - after.first)
    ends = [
        [curve.at(w, d) * leg**d for d in range(3)]
        for curve, w, leg in ((before, 1.0, leg_in), (after, 0.0, leg_out))
    ]
    polynomial = BPoly.from_derivatives([0.0, 1.0], ends)
    return Curve(polynomial, on_path=before.on_path and after.on_path)


def zone_fraction(curve: Curve, zone: float, robot: CompiledRobot, *, at_end: bool) -> float:
    """Fraction of a whole curve within `zone` [m] of one end; below half of it."""
    w = np.linspace(0.0, 1.0, SAMPLES)
    p = robot.pose(np.ascontiguousarray(curve.at(1.0 - w if at_end else w)))[:, :3, 3]
    distance = np.linalg.norm(p - p[0], axis=1)
    beyond = np.flatnonzero(distance >= zone)
    if not len(beyond):
        return LARGEST_FRACTION
    i = int(beyond[0])
    return min(float(np.interp(zone, distance[i - 1 : i + 1], w[i - 1 : i + 1])), LARGEST_FRACTION)
