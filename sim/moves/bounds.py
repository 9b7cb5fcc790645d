"""Limits of joints and path along a curve of motor angles phi(w)."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics import CompiledRobot, Limits

from .curves import Curve
from .instructions import Dynamics, Speed

CORNER_FRACTION = 0.8
"""Fraction of an acceleration limit for following a bend; the rest is for changing speed."""
TINY = 1e-12


@dataclass(frozen=True, kw_only=True)
class Bounds:
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
    """w' [1/s] at the programmed speed.

    full: w' [1/s] at the joints' speed limits; tool_rate: [m] of tool path per unit of w.
    """
    if speed.share:
        return speed.share * full
    return (speed.path or 0.0) / np.maximum(tool_rate, TINY)


def curve_bounds(
    curve: Curve, speed: Speed, robot: CompiledRobot, limits: Limits, dynamics: Dynamics, n: int
) -> Bounds:
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
    return Bounds(
        speed=np.minimum(np.minimum(full, wanted), bent),
        along=np.column_stack([d1 / of_joints, of_path * x1]),
        bend=bend,
    )
